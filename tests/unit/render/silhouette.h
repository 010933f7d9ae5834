#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "client/core/view/view.h"
#include "common/mesh.h"

namespace lode::test {

/// Pixel coordinates of a point in front of the camera, in double; the top left corner is 0, 0.
inline glm::dvec2 projectTo(const core::View& view, glm::dvec3 point) {
  const glm::dvec3 relative = point - view.eye_model;
  const double scale = view.height_px / 2.0 / std::tan(view.fov_y_rad / 2) / glm::dot(relative, view.forward);
  return {view.width_px / 2.0 + glm::dot(relative, glm::cross(view.forward, view.up)) * scale,
          view.height_px / 2.0 - glm::dot(relative, view.up) * scale};
}

/// The pixel centres that a mesh covers, by projection in double, without OpenGL. Skips triangles that reach
/// behind the camera.
class Silhouette {
 public:
  explicit Silhouette(const core::View& view)
      : view_(view), covered_(size_t{view.width_px} * view.height_px, false) {}

  void add(const Mesh& mesh, double step) {
    for (const glm::u32vec3& t : mesh.triangles) {
      std::array<glm::dvec2, 3> corner;
      bool before = true;
      for (int i = 0; i < 3; ++i) {
        const glm::dvec3 point = glm::dvec3(unpackPosition(mesh.positions[t[i]])) * step;
        before = before && glm::dot(point - view_.eye_model, view_.forward) > 0;
        corner[i] = projectTo(view_, point);
      }
      if (before) fill(corner);
    }
  }

  /// 1 if the pixel and its eight neighbours are covered, 0 if none is, -1 near the outline.
  int around(uint32_t x, uint32_t y) const {
    int count = 0, looked = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int64_t px = int64_t{x} + dx, py = int64_t{y} + dy;
        if (px < 0 || py < 0 || px >= view_.width_px || py >= view_.height_px) continue;
        ++looked;
        if (covered_[static_cast<size_t>(py * view_.width_px + px)]) ++count;
      }
    }
    return count == looked ? 1 : count == 0 ? 0 : -1;
  }

 private:
  void fill(const std::array<glm::dvec2, 3>& c) {
    const auto edge = [](glm::dvec2 a, glm::dvec2 b, glm::dvec2 p) {
      return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    };
    const auto first = [](double a, double b, double d, uint32_t limit) {
      return static_cast<uint32_t>(std::clamp(std::floor(std::min({a, b, d})), 0.0, double(limit)));
    };
    const auto last = [](double a, double b, double d, uint32_t limit) {
      return static_cast<uint32_t>(std::clamp(std::ceil(std::max({a, b, d})), 0.0, double(limit)));
    };
    for (uint32_t y = first(c[0].y, c[1].y, c[2].y, view_.height_px);
         y < last(c[0].y, c[1].y, c[2].y, view_.height_px); ++y) {
      for (uint32_t x = first(c[0].x, c[1].x, c[2].x, view_.width_px);
           x < last(c[0].x, c[1].x, c[2].x, view_.width_px); ++x) {
        const glm::dvec2 p(x + 0.5, y + 0.5);
        const double e0 = edge(c[0], c[1], p), e1 = edge(c[1], c[2], p), e2 = edge(c[2], c[0], p);
        const bool inside = (e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0);
        if (inside) covered_[size_t{y} * view_.width_px + x] = true;
      }
    }
  }

  core::View view_;
  std::vector<bool> covered_;
};

}  // namespace lode::test
