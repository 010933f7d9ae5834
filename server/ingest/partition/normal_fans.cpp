#include "server/ingest/partition/normal_fans.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/codec/surface_normals.h"
#include "common/groups.h"
#include "server/ingest/partition/leaf_mesh.h"

namespace lode::ingest {
namespace {

/// Margin for rounding errors in the quick test of findFans(): faces that pass it also pass the exact test,
/// in all pairs.
constexpr float kRounding = 1e-4f;
/// Largest number of fans per position of a leaf. A position with more fans gets a single fan, because so
/// many creases are noise.
constexpr size_t kMostFans = 32;

glm::vec3 directionOf(glm::i64vec3 cross) noexcept {
  const glm::dvec3 exact(cross);
  const double length = glm::length(exact);
  return length > 0 ? glm::vec3(exact / length) : glm::vec3(0);
}

/// Lists the triangle corners at some positions of a mesh.
class CornersAt {
 public:
  CornersAt(const NodeMesh& mesh, const std::vector<bool>& wanted) : begin_(wanted.size() + 1) {
    const auto forEach = [&](auto&& visit) {
      for (uint32_t c = 0; c < 3 * mesh.triangles.size(); ++c) {
        const uint32_t position = mesh.wedge_position[mesh.triangles[c / 3][static_cast<int>(c % 3)]];
        if (wanted[position]) visit(position, c);
      }
    };
    forEach([&](uint32_t position, uint32_t) { ++begin_[position + 1]; });
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    corners_.resize(begin_.back());
    std::vector<uint32_t> end(begin_.begin(), begin_.end() - 1);
    forEach([&](uint32_t position, uint32_t corner) { corners_[end[position]++] = corner; });
  }
  std::span<const uint32_t> operator[](uint32_t position) const noexcept {
    return std::span(corners_).subspan(begin_[position], begin_[position + 1] - begin_[position]);
  }

 private:
  std::vector<uint32_t> begin_, corners_;
};

/// An edge at a position, together with one of the faces that have the edge.
struct Side {
  uint32_t other;  ///< position at the edge's other end
  uint32_t index;  ///< index of the face's corner in the list of corners at the position
  auto operator<=>(const Side&) const = default;
};

/// Returns the sides at a position, sorted by edge.
std::vector<Side> sidesOf(const NodeMesh& mesh, std::span<const uint32_t> corners) {
  std::vector<Side> sides;
  for (uint32_t i = 0; i < corners.size(); ++i) {
    const glm::u32vec3& t = mesh.triangles[corners[i] / 3];
    for (const uint32_t on : {1u, 2u})
      sides.push_back({mesh.wedge_position[t[static_cast<int>((corners[i] + on) % 3)]], i});
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

glm::i64vec3 crossOf(const NodeMesh& mesh, const glm::u32vec3& t) {
  const auto at = [&](uint32_t wedge) { return mesh.positions[mesh.wedge_position[wedge]]; };
  return areaNormal(at(t.x), at(t.y), at(t.z));
}

/// Joins each group with a zero sum of normals to the group with the longest sum.
void joinDirectionless(Groups& groups, std::span<const glm::i64vec3> sums) {
  std::vector<glm::i64vec3> totals(sums.size(), glm::i64vec3(0));
  for (uint32_t i = 0; i < sums.size(); ++i) totals[groups.find(i)] += sums[i];
  uint32_t longest = 0;
  double length = -1;
  for (uint32_t i = 0; i < sums.size(); ++i) {
    if (const double own = glm::length(glm::dvec3(totals[i])); own > length) {
      longest = i;
      length = own;
    }
  }
  for (uint32_t i = 0; i < sums.size(); ++i)
    if (groups.find(i) == i && totals[i] == glm::i64vec3(0)) groups.join(i, longest);
}

/// Groups the corners at a position into fans, and numbers the fans in the order of their first corners.
/// @return number of fans.
uint32_t groupCorners(const NodeMesh& mesh, std::span<const glm::vec3> directions,
                      std::span<const uint32_t> corners, const CreaseAngle& crease,
                      std::vector<uint32_t>& numbers) {
  Groups groups(corners.size());
  const std::vector<Side> sides = sidesOf(mesh, corners);
  for (size_t i = 1; i < sides.size(); ++i) {
    if (sides[i].other != sides[i - 1].other) continue;
    const uint32_t a = corners[sides[i - 1].index] / 3, b = corners[sides[i].index] / 3;
    if (crease.isSmooth(directions[a], directions[b])) groups.join(sides[i - 1].index, sides[i].index);
  }
  std::vector<glm::i64vec3> crosses;
  for (const uint32_t corner : corners) crosses.push_back(crossOf(mesh, mesh.triangles[corner / 3]));
  joinDirectionless(groups, crosses);
  numbers.assign(corners.size(), 0);
  uint32_t count = 0;
  for (uint32_t i = 0; i < corners.size(); ++i)
    numbers[i] = groups.find(i) == i ? count++ : numbers[groups.find(i)];
  if (count <= kMostFans) return count;
  numbers.assign(corners.size(), 0);
  return 1;
}

}  // namespace

CreaseAngle::CreaseAngle(double degrees) noexcept
    : has_none(degrees >= 180),
      cosine(static_cast<float>(std::cos(degrees * std::numbers::pi / 180))),
      cosine_of_half(static_cast<float>(std::cos(degrees * std::numbers::pi / 360))) {}

NormalFans findFans(const NodeMesh& mesh, const CreaseAngle& crease) {
  const auto positions = static_cast<uint32_t>(mesh.positions.size());
  const auto positionAt = [&](size_t corner) {
    return mesh.wedge_position[mesh.triangles[corner / 3][static_cast<int>(corner % 3)]];
  };
  const std::vector<glm::i64vec3> whole = sumNormals(mesh);
  std::vector<glm::vec3> directions;
  std::vector<bool> may_part(positions);
  if (!crease.has_none) {
    // Quick test: if both normals are within half the crease angle of one axis, two faces meet within the
    // crease angle.
    std::vector<glm::vec3> axes;
    for (const glm::i64vec3& sum : whole) axes.push_back(directionOf(sum));
    for (const glm::u32vec3& t : mesh.triangles) directions.push_back(directionOf(crossOf(mesh, t)));
    for (size_t c = 0; c < 3 * mesh.triangles.size(); ++c) {
      const bool is_near =
          glm::dot(directions[c / 3], axes[positionAt(c)]) >= crease.cosine_of_half + kRounding;
      if (!is_near) may_part[positionAt(c)] = true;
    }
  }
  NormalFans fans;
  fans.first.resize(positions + 1);
  fans.of_corner.resize(3 * mesh.triangles.size());
  const CornersAt corners_at(mesh, may_part);
  std::vector<uint32_t> numbers;
  for (uint32_t p = 0; p < positions; ++p) {
    fans.first[p] = static_cast<uint32_t>(fans.sums.size());
    if (!may_part[p]) {
      fans.sums.push_back(whole[p]);
      continue;
    }
    const std::span<const uint32_t> corners = corners_at[p];
    const uint32_t count = groupCorners(mesh, directions, corners, crease, numbers);
    fans.sums.resize(fans.sums.size() + count, glm::i64vec3(0));
    for (size_t i = 0; i < corners.size(); ++i) {
      fans.of_corner[corners[i]] = fans.first[p] + numbers[i];
      fans.sums[fans.first[p] + numbers[i]] += crossOf(mesh, mesh.triangles[corners[i] / 3]);
    }
  }
  fans.first[positions] = static_cast<uint32_t>(fans.sums.size());
  for (size_t c = 0; c < fans.of_corner.size(); ++c)
    if (!may_part[positionAt(c)]) fans.of_corner[c] = fans.first[positionAt(c)];
  return fans;
}

std::vector<std::vector<ListedFan>> listFans(const NodeMesh& mesh, const NormalFans& fans,
                                             std::span<const uint32_t> positions) {
  std::vector<bool> wanted(mesh.positions.size());
  for (const uint32_t position : positions) wanted[position] = true;
  const CornersAt corners_at(mesh, wanted);
  std::vector<std::vector<ListedFan>> result;
  for (const uint32_t position : positions) {
    const std::span<const uint32_t> corners = corners_at[position];
    const uint32_t first = fans.first[position], count = fans.first[position + 1] - first;
    std::vector<ListedFan> listed(count), more;
    for (uint32_t fan = 0; fan < count; ++fan) {
      listed[fan].fan = static_cast<uint16_t>(fan);
      listed[fan].sum = fans.sums[first + fan];
    }
    const auto addEnd = [&](const Side& side) {
      ListedFan* fan = &listed[fans.of_corner[corners[side.index]] - first];
      if (fan->ends == ListedFan::kMaxEnds) {
        more.emplace_back().fan = fan->fan;
        fan = &more.back();
      }
      fan->other[fan->ends] = mesh.positions[side.other];
      fan->direction[fan->ends++] = directionOf(crossOf(mesh, mesh.triangles[corners[side.index] / 3]));
    };
    const std::vector<Side> sides = sidesOf(mesh, corners);
    for (size_t begin = 0, end; begin < sides.size(); begin = end) {
      for (end = begin; end < sides.size() && sides[end].other == sides[begin].other;) ++end;
      if (end - begin != 2)
        for (size_t i = begin; i < end; ++i) addEnd(sides[i]);
    }
    listed.insert(listed.end(), more.begin(), more.end());
    result.push_back(std::move(listed));
  }
  return result;
}

std::vector<uint16_t> joinFans(std::span<const ListedFan> listed, const CreaseAngle& crease) {
  struct End {
    PositionCode other;
    uint32_t listing;
    glm::vec3 direction;
  };
  Groups groups(listed.size());
  std::vector<End> ends;
  std::vector<glm::i64vec3> sums;
  // Index of the leaf's first entry. The first entries of all its fans come first, in order; additional
  // entries follow.
  uint32_t first = 0;
  for (uint32_t i = 0; i < listed.size(); ++i) {
    const ListedFan& fan = listed[i];
    if (fan.leaf != listed[first].leaf) first = i;
    groups.join(first + fan.fan, i);
    for (uint16_t e = 0; e < fan.ends; ++e) ends.push_back({fan.other[e], i, fan.direction[e]});
    sums.push_back(fan.sum);
  }
  std::stable_sort(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.other < b.other; });
  for (size_t i = 1; i < ends.size(); ++i)
    if (ends[i].other == ends[i - 1].other && crease.isSmooth(ends[i].direction, ends[i - 1].direction))
      groups.join(ends[i].listing, ends[i - 1].listing);
  joinDirectionless(groups, sums);
  std::vector<glm::i64vec3> totals(listed.size(), glm::i64vec3(0));
  for (uint32_t i = 0; i < listed.size(); ++i) totals[groups.find(i)] += sums[i];
  std::vector<uint16_t> normals;
  for (uint32_t i = 0; i < listed.size(); ++i) normals.push_back(normalOf(totals[groups.find(i)]));
  return normals;
}

}  // namespace lode::ingest
