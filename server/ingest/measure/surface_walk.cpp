#include "server/ingest/measure/surface_walk.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "server/ingest/mesh/point_triangle.h"

namespace lode::ingest {
namespace {

/// Largest number of triangles around a position of which a walk visits all. Around a hub, a position with
/// more triangles, a walk visits only some. Otherwise n walks on n triangles around one position would take
/// time proportional to n * n.
constexpr uint32_t kMostAround = 256;
/// Triangles count as being on one side of a position if the mean direction to them has a squared length
/// above this value.
constexpr float kOneSided = 0.01f;
/// Number of groups of four triangles that visitSome() visits per round.
constexpr uint32_t kSpotsAtOnce = 32;

float squaredLength(glm::vec3 v) noexcept { return glm::dot(v, v); }

/// Returns a number from 0 to 4 that grows with the angle of a direction in the plane.
float turnOf(float x, float y) noexcept {
  const float sum = std::abs(x) + std::abs(y);
  if (sum == 0) return 0;
  return x >= 0 ? (y >= 0 ? y / sum : 4 + y / sum) : 2 - y / sum;
}

glm::vec3 vectorOf(Four four) noexcept { return {four[0], four[1], four[2]}; }

/// Returns the corners of a triangle. The sums have no rounding error, because positions are whole lattice
/// steps.
std::array<Four, 3> cornersOf(const PackedTriangle& t) noexcept {
  return {t.a(), t.a() + t.ab(), t.a() + t.ac()};
}

/// A triangle's edges with their outward directions.
class TriangleOutline {
 public:
  explicit TriangleOutline(const PackedTriangle& t) noexcept
      : corners_(cornersOf(t)),
        starts_(corners_[0], corners_[1], corners_[2], corners_[0]),
        sides_(t.ab(), t.ac() - t.ab(), Four{} - t.ac(), t.ab()),
        squared_lengths_(dot(sides_, sides_)),
        outwards_(cross(sides_, FourVectors(glm::cross(vectorOf(t.ab()), vectorOf(t.ac()))))) {}

  Four corner(size_t k) const noexcept { return corners_[k % 3]; }

  /// Returns the edge that the point lies beyond; the farthest one if there are several, -1 if there is none.
  /// In the usual case of at most one such edge, avoids a branch that the processor could not predict.
  /// @param passed_over  edge to ignore, or -1
  int edgeTowards(glm::vec3 point, int passed_over) const noexcept {
    const Four heights = dot(outwards_, FourVectors(point) - starts_);
    const FourTruths is_beyond = heights > 0;
    const int all = (is_beyond[0] & 1) | (is_beyond[1] & 2) | (is_beyond[2] & 4);
    const int edges = passed_over < 0 ? all : all & ~(1 << passed_over);
    const bool has_several = (edges & (edges - 1)) != 0;
    if (!has_several) return (edges >> 1) - (edges == 0);
    int most = -1;
    for (int k = 0; k < 3; ++k) {
      if ((edges >> k & 1) == 0) continue;
      const float farthest = most < 0 ? 0 : heights[most] / std::sqrt(squared_lengths_[most]);
      if (heights[k] * heights[k] > farthest * farthest * squared_lengths_[k]) most = k;
    }
    return most;
  }

 private:
  std::array<Four, 3> corners_;
  FourVectors starts_, sides_;
  Four squared_lengths_;
  /// Outward direction of each edge, scaled by the lengths of the edge and of the normal.
  FourVectors outwards_;
};

}  // namespace

SurfaceWalk::SurfaceWalk(const NodeMesh& mesh) : begin_(mesh.positions.size() + 1) {
  const auto at = [&](uint32_t position) { return glm::vec3(unpackPosition(mesh.positions[position])); };
  corners_.reserve(mesh.triangles.size());
  triangles_.reserve(mesh.triangles.size());
  for (const glm::u32vec3& t : mesh.triangles) {
    const glm::u32vec3 corners(mesh.wedge_position[t.x], mesh.wedge_position[t.y], mesh.wedge_position[t.z]);
    const glm::vec3 a = at(corners.x), b = at(corners.y), c = at(corners.z);
    corners_.push_back(corners);
    triangles_.emplace_back(a, TriangleSides(b - a, c - a));
    longest_edge_ =
        std::max({longest_edge_, squaredLength(b - a), squaredLength(c - b), squaredLength(a - c)});
    for (int k = 0; k < 3; ++k) ++begin_[corners[k]];
  }
  longest_edge_ = std::sqrt(longest_edge_);
  uint32_t end = 0;
  for (uint32_t& begin : begin_) begin = end += begin;
  around_.resize(end);
  for (auto t = static_cast<uint32_t>(corners_.size()); t-- > 0;) {
    for (int k = 0; k < 3; ++k) around_[--begin_[corners_[t][k]]] = t;
  }
  for (uint32_t position = 0; position < mesh.positions.size(); ++position)
    if (isHub(position)) sortAround(position, at(position));
}

void SurfaceWalk::sortAround(uint32_t position, glm::vec3 at) {
  const std::span<uint32_t> around(around_.data() + begin_[position],
                                   begin_[position + 1] - begin_[position]);
  const auto towards = [&](uint32_t t) {
    const PackedTriangle& triangle = triangles_[t];
    const glm::vec3 away =
        3.f * (vectorOf(triangle.a()) - at) + vectorOf(triangle.ab()) + vectorOf(triangle.ac());
    const float length = std::sqrt(squaredLength(away));
    return length > 0 ? away / length : away;
  };
  glm::vec3 sum(0), squares(0);
  for (const uint32_t t : around) {
    const glm::vec3 direction = towards(t);
    sum += direction;
    squares += direction * direction;
  }
  const bool is_one_sided =
      squaredLength(sum) > kOneSided * static_cast<float>(around.size()) * static_cast<float>(around.size());
  const glm::vec3 axis = is_one_sided                                       ? glm::normalize(sum)
                         : squares.x <= squares.y && squares.x <= squares.z ? glm::vec3(1, 0, 0)
                         : squares.y <= squares.z                           ? glm::vec3(0, 1, 0)
                                                                            : glm::vec3(0, 0, 1);
  const glm::vec3 aside =
      glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0)));
  const glm::vec3 ahead = glm::cross(axis, aside);
  std::vector<std::pair<float, uint32_t>> order;
  order.reserve(around.size());
  for (const uint32_t t : around) {
    const glm::vec3 direction = towards(t);
    order.emplace_back(turnOf(glm::dot(direction, aside), glm::dot(direction, ahead)), t);
  }
  std::sort(order.begin(), order.end());
  std::transform(order.begin(), order.end(), around.begin(), [](const auto& entry) { return entry.second; });
}

float SurfaceWalk::distance(glm::vec3 point, uint32_t start, float tolerance) const noexcept {
  return std::sqrt(walk(point, start, tolerance * tolerance).squared);
}

float SurfaceWalk::distanceAndAdvance(glm::vec3 point, uint32_t& start, float tolerance) const noexcept {
  const Nearest nearest = walk(point, start, tolerance * tolerance);
  if (!std::isinf(nearest.squared)) start = corners_[nearest.triangle].x;
  return std::sqrt(nearest.squared);
}

float SurfaceWalk::distanceFrom(glm::vec3 point, uint32_t& triangle, float tolerance) const noexcept {
  const glm::u32vec3& t = corners_[triangle];
  const std::array<Four, 3> corners = cornersOf(triangles_[triangle]);
  const auto away = [&](size_t k) { return squaredLength(vectorOf(corners[k]) - point); };
  const float a = away(0), b = away(1), c = away(2);
  const uint32_t start = a <= b && a <= c ? t.x : b <= c ? t.y : t.z;
  const Nearest nearest = walk(point, start, tolerance * tolerance);
  triangle = nearest.triangle;
  return std::sqrt(nearest.squared);
}

SurfaceWalk::Place SurfaceWalk::placeOf(glm::vec3 point, uint32_t start) const noexcept {
  if (const std::optional<Place> above = placeAround(point, start)) return *above;
  const Nearest nearest = walk(point, start, 0);
  const PackedTriangle& t = triangles_[nearest.triangle];
  const TriangleSides sides(vectorOf(t.ab()), vectorOf(t.ac()));
  const glm::vec2 shares = nearestInTriangle(point - vectorOf(t.a()), sides).shares;
  return {nearest.triangle, {1 - shares.x - shares.y, shares}, std::sqrt(nearest.squared)};
}

SurfaceWalk::Place SurfaceWalk::placeAt(uint32_t position) const noexcept {
  const uint32_t first = around_[begin_[position]];
  return {first, glm::vec3(glm::equal(corners_[first], glm::u32vec3(position))), 0};
}

/// Projects a point into the triangles around a position, and returns the nearest projection. Most points
/// project into one of these triangles, which then is usually the nearest triangle of all. Returns nothing if
/// the point projects into none of them, if the position is a hub, or if the triangles face in opposite
/// directions, as at the edge of a thin plate, where another triangle may be nearer.
std::optional<SurfaceWalk::Place> SurfaceWalk::placeAround(glm::vec3 point,
                                                           uint32_t position) const noexcept {
  float nearest = std::numeric_limits<float>::infinity();
  Place place;
  const FourVectors points(point);
  const uint32_t end = begin_[position + 1];
  if (isHub(position)) return std::nullopt;
  FourVectors first_normal;
  for (uint32_t i = begin_[position]; i < end; i += 4) {
    const FourTriangles four = trianglesFrom(i, end);
    const FourVectors ap = points - four.a(), normals = cross(four.ab(), four.ac());
    if (i == begin_[position]) first_normal = FourVectors({normals.x[0], normals.y[0], normals.z[0]});
    if (anyOf(dot(normals, first_normal) < 0)) return std::nullopt;
    const Four of_b = dot(normals, cross(ap, four.ac())), of_c = dot(normals, cross(four.ab(), ap)),
               all = dot(normals, normals), of_a = all - of_b - of_c;
    const auto is_above = (of_b > 0) & (of_c > 0) & (of_a > 0);
    if (!anyOf(is_above)) continue;
    // Measure the distance from the foot point: in slivers, a distance along the normal would be mostly
    // rounding noise.
    const FourVectors away = ap - (of_b * four.ab() + of_c * four.ac()) / all;
    const Four squared = dot(away, away);
    for (uint32_t k = 0; k < 4; ++k) {
      if (!is_above[k] || squared[k] >= nearest) continue;
      nearest = squared[k];
      place = {around_[i + k], glm::vec3(of_a[k], of_b[k], of_c[k]) / all[k], std::sqrt(squared[k])};
    }
  }
  return std::isinf(nearest) ? std::nullopt : std::optional(place);
}

SurfaceWalk::Nearest SurfaceWalk::walk(glm::vec3 point, uint32_t start,
                                       float tolerance_squared) const noexcept {
  Nearest best{std::numeric_limits<float>::infinity(), 0};
  if (tolerance_squared > 0) visitAbove(point, start, tolerance_squared, best);
  if (best.squared <= tolerance_squared) return best;
  visitAround(point, start, tolerance_squared, best);
  if (std::isinf(best.squared)) return best;
  glm::u32vec3 done(start);  // positions around which visitAround() has searched
  for (float before = std::numeric_limits<float>::infinity(); best.squared < before;) {
    if (best.squared <= tolerance_squared || isAbove(point, best.triangle)) break;
    before = best.squared;
    const glm::u32vec3 corners = corners_[best.triangle];
    for (int k = 0; k < 3; ++k) {
      if (corners[k] != done.x && corners[k] != done.y && corners[k] != done.z)
        visitAround(point, corners[k], tolerance_squared, best);
    }
    done = corners;
  }
  return best;
}

uint32_t SurfaceWalk::acrossEdge(uint32_t triangle, uint32_t from, uint32_t to) const noexcept {
  if (begin_[to + 1] - begin_[to] < begin_[from + 1] - begin_[from]) std::swap(from, to);
  const auto isAcross = [&](uint32_t other) {
    const glm::u32vec3& t = corners_[other];
    const uint32_t has_both = (t.x == to) | (t.y == to) | (t.z == to);
    return has_both & (other != triangle);
  };
  uint32_t found = triangle;
  if (isHub(from)) {
    const auto end = around_.begin() + begin_[from + 1];
    const auto at = std::find_if(around_.begin() + begin_[from], end, isAcross);
    return at == end ? found : *at;
  }
  for (uint32_t i = begin_[from + 1];
       i-- > begin_[from];) {  // backwards, so that the first match wins without a branch
    const uint32_t chosen = 0u - isAcross(around_[i]);
    found = (chosen & around_[i]) | (~chosen & found);
  }
  return found;
}

bool SurfaceWalk::chainAlong(const Segment& segment, uint32_t first, uint32_t last, float near_squared,
                             TriangleChain& chain) const noexcept {
  chain.triangles[0] = first;
  chain.edge_count = 0;
  glm::u32vec2 came_by(~0u);
  for (uint32_t here = first; here != last;) {
    if (chain.edge_count == TriangleChain::kMostEdges) return false;
    const std::array<uint32_t, 4> t{corners_[here].x, corners_[here].y, corners_[here].z, corners_[here].x};
    const auto isBack = [&](size_t k) { return int{t[k] == came_by.y} & int{t[k + 1] == came_by.x}; };
    const int back = isBack(0) + 2 * isBack(1) + 3 * isBack(2) - 1;
    const TriangleOutline outline(triangles_[here]);
    const int towards = outline.edgeTowards(segment.to, back);
    if (towards < 0) return squaredDistance(segment.to, here) <= near_squared;
    const auto way = static_cast<size_t>(towards);
    came_by = {t[way], t[way + 1]};
    const uint32_t next = acrossEdge(here, came_by.x, came_by.y);
    if (next == here) return false;
    chain.from[chain.edge_count] = outline.corner(way);
    chain.to[chain.edge_count] = outline.corner(way + 1);
    chain.triangles[++chain.edge_count] = next;
    here = next;
  }
  return true;
}

TriangleTree::Nearest SurfaceWalk::nearestOfAll(glm::vec3 point, TriangleTree::Nearest bound) const noexcept {
  Nearest best{bound.squared, bound.triangle};
  float distance = bound.distance, reach = distance + longest_edge_;
  for (uint32_t t = 0; t < triangles_.size(); ++t) {
    if (squaredLength(point - vectorOf(triangles_[t].a())) > reach * reach) continue;
    const float before = best.squared;
    visit(point, t, best);
    if (best.squared == before) continue;
    distance = std::sqrt(best.squared);
    reach = distance + longest_edge_;
  }
  return {best.squared, distance, best.triangle};
}

/// Returns true if the point of the triangle that is nearest to `point` lies inside the triangle. Its
/// neighbours are then usually farther away.
bool SurfaceWalk::isAbove(glm::vec3 point, uint32_t triangle) const noexcept {
  const std::array<Four, 3> corners = cornersOf(triangles_[triangle]);
  const glm::vec3 a = vectorOf(corners[0]) - point, b = vectorOf(corners[1]) - point,
                  c = vectorOf(corners[2]) - point;
  const glm::vec3 normal = glm::cross(b - a, c - a);
  return glm::dot(normal, glm::cross(a, b)) > 0 && glm::dot(normal, glm::cross(b, c)) > 0 &&
         glm::dot(normal, glm::cross(c, a)) > 0;
}

bool SurfaceWalk::isHub(uint32_t position) const noexcept {
  return begin_[position + 1] - begin_[position] > kMostAround;
}

float SurfaceWalk::visitFour(const FourVectors& points, uint32_t begin, uint32_t end, float tolerance_squared,
                             Nearest& best) const noexcept {
  const Four found = trianglesFrom(begin, end).squaredDistances(points);
  const unsigned within = bitsOf(found <= tolerance_squared);
  const float least = leastOf(found);
  if (within == 0 && !(least < best.squared)) return least;
  const auto first = static_cast<uint32_t>(std::countr_zero(within != 0 ? within : bitsOf(found == least)));
  best = {found[first], around_[begin + first]};
  return least;
}

void SurfaceWalk::visitAround(glm::vec3 point, uint32_t position, float tolerance_squared,
                              Nearest& best) const noexcept {
  const FourVectors points(point);
  const uint32_t end = begin_[position + 1];
  if (isHub(position)) return visitSome(points, begin_[position], end, tolerance_squared, best);
  for (uint32_t i = begin_[position]; i < end && best.squared > tolerance_squared; i += 4)
    visitFour(points, i, end, tolerance_squared, best);
}

/// Searches the triangles around a hub, which are sorted around an axis; see sortAround(). The first round
/// visits groups of four triangles spread over the whole list. Each further round visits groups spread over
/// the neighbourhood of the nearest group, until the groups adjoin.
void SurfaceWalk::visitSome(const FourVectors& points, uint32_t begin, uint32_t end, float tolerance_squared,
                            Nearest& best) const noexcept {
  uint32_t first = begin, last = end, stride = end - begin;
  while (stride > 4 && best.squared > tolerance_squared) {
    stride = std::max(4u, (last - first + kSpotsAtOnce - 1) / kSpotsAtOnce);
    uint32_t nearest = first;
    float least = std::numeric_limits<float>::infinity();
    for (uint32_t i = first; i < last && best.squared > tolerance_squared; i += stride) {
      const float found = visitFour(points, i, end, tolerance_squared, best);
      if (!(found < least)) continue;
      least = found;
      nearest = i;
    }
    first = nearest - std::min(stride, nearest - begin);
    last = nearest + std::min(stride, end - nearest);
  }
}

/// Finds a triangle around a position that is within the tolerance of the point and that contains the point's
/// projection. Most walks end in this function. It takes a third of the time needed for exact distances.
void SurfaceWalk::visitAbove(glm::vec3 point, uint32_t position, float tolerance_squared,
                             Nearest& best) const noexcept {
  if (isHub(position)) return;
  const FourVectors points(point);
  const uint32_t end = begin_[position + 1];
  for (uint32_t i = begin_[position]; i < end; i += 4) {
    const Four found = trianglesFrom(i, end).squaredHeights(points);
    const unsigned within = bitsOf(found <= tolerance_squared);
    if (within == 0) continue;
    const auto first = static_cast<uint32_t>(std::countr_zero(within));
    best = {found[first], around_[i + first]};
    return;
  }
}

void SurfaceWalk::visit(glm::vec3 point, uint32_t triangle, Nearest& best) const noexcept {
  const float squared = squaredDistance(point, triangle);
  if (squared < best.squared) best = {squared, triangle};
}

}  // namespace lode::ingest
