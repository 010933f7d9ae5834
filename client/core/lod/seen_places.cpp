#include "client/core/lod/seen_places.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "client/core/lod/refine_options.h"
#include "common/lattice.h"

namespace lode::core {
namespace {

constexpr double kWidth = 160, kHeight = 90;  // largest size of the depth buffer in pixels, without margin
constexpr size_t kFewOf = 512;           // a node is hidden if it has fewer than 1/512 of all marked cells
constexpr size_t kFewOfPart = 4;         // and fewer than 1/4 of the mean number per part
constexpr double kMostTried = 1u << 22;  // largest number of pixel tests over all triangles

/// Inserts two zero bits between the bits of a coordinate.
uint64_t spread(uint64_t bits) {
  bits = (bits | bits << 32) & 0x1f00000000ffff;
  bits = (bits | bits << 16) & 0x1f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  return (bits | bits << 2) & 0x1249249249249249;
}

/// Returns the cell at kMaxDepth that contains a point.
/// @param in_root  position in the root cell, from 0 to 1 along each axis.
NodeKey cellAt(glm::dvec3 in_root) {
  constexpr double kCells = 1u << kMaxDepth;
  const glm::uvec3 cell(glm::clamp(in_root * kCells, 0.0, kCells - 1));
  return {kRootKey.value << 3 * kMaxDepth | spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2};
}

/// A small depth buffer, into which triangles are rasterised.
class SmallPicture {
 public:
  explicit SmallPicture(const View& view)
      : eye_(view.eye_model),
        forward_(view.forward),
        right_(glm::cross(view.forward, view.up)),
        up_(view.up),
        near_(view.near_model) {
    const double pixel_px = std::max(view.width_px / kWidth, view.height_px / kHeight);
    const auto side = [&](uint32_t of_view) {
      return std::max(1, static_cast<int>(of_view / pixel_px * kMarginWidening));
    };
    width_ = side(view.width_px);
    height_ = side(view.height_px);
    focal_ = view.height_px / (2 * std::tan(view.fov_y_rad / 2)) / pixel_px;
    nearness_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), 0);
  }

  void draw(const Mesh& mesh, double step) {
    std::vector<glm::dvec3> vertices;
    vertices.reserve(mesh.positions.size());
    for (const PositionCode& position : mesh.positions) {
      const glm::dvec3 arm = glm::dvec3(unpackPosition(position)) * step - eye_;
      vertices.emplace_back(glm::dot(arm, right_), glm::dot(arm, up_), glm::dot(arm, forward_));
    }
    for (const glm::u32vec3& triangle : mesh.triangles)
      clip({vertices[triangle.x], vertices[triangle.y], vertices[triangle.z]});
  }

  /// Returns false if the pixel limit stopped rasterisation.
  bool complete() const { return tried_ <= kMostTried; }

  /// Calls `take` with the surface point of each covered pixel.
  template <typename Take>
  void forEachPoint(Take&& take) const {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const double nearness = nearness_[at(x, y)];
        if (nearness == 0) continue;
        const double aside = (x + 0.5 - width_ / 2.0) / focal_, above = (y + 0.5 - height_ / 2.0) / focal_;
        take(eye_ + (forward_ + right_ * aside + up_ * above) / nearness);
      }
  }

 private:
  size_t at(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }

  /// Clips a triangle at the near plane and draws the rest. The coordinate axes point right, up and away from
  /// the eye.
  void clip(const std::array<glm::dvec3, 3>& corners) {
    std::array<glm::dvec3, 4> seen;
    size_t count = 0;
    for (size_t i = 0; i < 3; ++i) {
      const glm::dvec3 &a = corners[i], &b = corners[(i + 1) % 3];
      if (a.z > near_) seen[count++] = project(a);
      if ((a.z > near_) != (b.z > near_))
        seen[count++] = project(a + (b - a) * ((near_ - a.z) / (b.z - a.z)));
    }
    for (size_t i = 2; i < count; ++i) fill(seen[0], seen[i - 1], seen[i]);
  }

  /// Returns pixel coordinates and 1 / depth, which is linear across a projected triangle.
  glm::dvec3 project(glm::dvec3 p) const {
    return {width_ / 2.0 + focal_ * p.x / p.z, height_ / 2.0 + focal_ * p.y / p.z, 1 / p.z};
  }

  /// Writes the pixels whose centre the triangle covers, with a depth test.
  void fill(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    const auto first = [](double least) { return std::max(0.0, std::ceil(least - 0.5)); };
    const auto last = [](double most, int side) { return std::min(side - 1.0, std::floor(most - 0.5)); };
    const double left = first(std::min({a.x, b.x, c.x})), right = last(std::max({a.x, b.x, c.x}), width_);
    const double low = first(std::min({a.y, b.y, c.y})), high = last(std::max({a.y, b.y, c.y}), height_);
    if (left > right || low > high) return;
    tried_ += (right - left + 1) * (high - low + 1);
    if (!complete()) return;
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) return;
    // Barycentric weights and nearness (1 / depth) are linear in pixel coordinates.
    const double right_b = (c.y - a.y) / area, right_c = (a.y - b.y) / area;
    const double right_nearness = right_b * (b.z - a.z) + right_c * (c.z - a.z);
    for (double y = low; y <= high; ++y) {
      const double across = left + 0.5 - a.x, above = y + 0.5 - a.y;
      double of_b = across * right_b - above * (c.x - a.x) / area;
      double of_c = across * right_c + above * (b.x - a.x) / area;
      double nearness = a.z + of_b * (b.z - a.z) + of_c * (c.z - a.z);
      double* nearest = &nearness_[at(static_cast<int>(left), static_cast<int>(y))];
      for (double x = left; x <= right; ++x, ++nearest) {
        if (of_b >= 0 && of_c >= 0 && of_b + of_c <= 1) *nearest = std::max(*nearest, nearness);
        of_b += right_b;
        of_c += right_c;
        nearness += right_nearness;
      }
    }
  }

  const glm::dvec3 eye_, forward_, right_, up_;
  const double near_;
  int width_ = 0, height_ = 0;
  double focal_ = 0, tried_ = 0;
  std::vector<double> nearness_;  // 1 / depth of each pixel, row by row; 0: no surface
};

}  // namespace

std::optional<SeenPlaces> SeenPlaces::of(const Cut& cut, const ModelSummary& model) {
  SmallPicture picture(cut.view);
  for (const CutPart& part : cut.parts) picture.draw(*part.mesh, model.lattice.step);
  if (!picture.complete()) return std::nullopt;
  // The root cell is a cube at the lattice origin; its side is the longest side of the model.
  const glm::uvec3 extent = model.box.max;
  const double side_model = model.lattice.step * (std::max({extent.x, extent.y, extent.z}) + 1.0);
  SeenPlaces seen;
  picture.forEachPoint([&](glm::dvec3 point) { seen.places_.push_back(cellAt(point / side_model)); });
  std::ranges::sort(seen.places_);
  seen.few_ = seen.places_.size() / std::max(kFewOf, kFewOfPart * cut.parts.size());
  return seen;
}

bool SeenPlaces::in(NodeKey node) const noexcept {
  const int below = 3 * (kMaxDepth - node.depth());
  const auto first = std::ranges::lower_bound(places_, NodeKey{node.value << below});
  const auto end = std::lower_bound(first, places_.end(), NodeKey{(node.value + 1) << below});
  return first != end && static_cast<size_t>(end - first) >= few_;
}

}  // namespace lode::core
