#include "server/ingest/nodes/lod_targets.h"

#include <algorithm>
#include <cmath>

#include "common/limits.h"

namespace lode::ingest {

namespace {

constexpr int kFineStepDepth = 2;
/// A node gets fine steps if the leaves below it have at least this many times triangles_per_node triangles.
constexpr uint64_t kFineStepNodes = 16;
constexpr size_t kTrianglesPerLocked = 8;
constexpr size_t kTrianglesPerLockedBelowRoot = 12;
// Above kLargeNodes * triangles_per_node triangles, or above kLargeTriangles, a node's last LOD keeps only
// kTrianglesPerLockedOfLarge triangles per locked vertex. This bounds the input of the parent. It matters
// most for the root: its input takes the most memory.
constexpr size_t kLargeNodes = 8;
constexpr size_t kLargeTriangles = 1 << 17;
/// Smallest value of the limit above for nodes that are not children of the root, in triangles.
constexpr size_t kLeastLargeTriangles = 1 << 14;
constexpr size_t kTrianglesPerLockedOfLarge = 4;
/// A step that reduces by a factor f keeps at least the triangles at locked vertices plus f * kInnerFactor of
/// the others.
constexpr double kInnerFactor = 2.0 / 3;
/// A node gets far LODs if the leaves below it have at least this many times triangles_per_node triangles.
constexpr uint64_t kFarLodNodes = 8;
constexpr size_t kFarLodShare = 4;  ///< far LODs end at triangles_per_node / kFarLodShare triangles
/// Far LODs also end at this number of triangles per locked vertex, if it is larger.
constexpr size_t kFarLodTrianglesPerLocked = 2;

bool hasMuchBelow(const LodRule& rule) {
  return rule.original_triangles >= kFineStepNodes * rule.triangles_per_node;
}

/// Returns the triangle count of the LOD after one with `target` triangles. @param locked  how many of the
/// `target` triangles are at locked vertices.
double stepFrom(double target, double locked, double factor) {
  return std::max(factor * target, locked + factor * kInnerFactor * (target - locked));
}

}  // namespace

size_t mostTriangles(const LodRule& rule) {
  if (rule.depth == 0) return kRootTriangles;
  const bool is_of_large_root = rule.depth == 1 && hasMuchBelow(rule);
  const size_t per_locked = is_of_large_root ? kTrianglesPerLockedBelowRoot : kTrianglesPerLocked;
  const size_t least_large = rule.depth == 1 ? 0 : kLeastLargeTriangles;
  const size_t large = std::clamp(kLargeNodes * rule.triangles_per_node, least_large, kLargeTriangles);
  const size_t roomy = std::min(per_locked * rule.locked, large);
  const size_t least = std::max({rule.triangles_per_node, roomy, kTrianglesPerLockedOfLarge * rule.locked});
  return std::min<size_t>(least, kMaxLodTriangles);
}

std::vector<size_t> lodTargets(size_t triangles, const LodRule& rule) {
  const bool is_root = rule.depth == 0;
  const size_t limit = mostTriangles(rule);
  const bool is_fine = is_root || (rule.depth <= kFineStepDepth && hasMuchBelow(rule));
  const double factor = is_fine ? std::sqrt(0.5) : 0.5;
  std::vector<size_t> targets;
  if (rule.is_leaf && triangles <= limit) return targets;
  const auto locked = static_cast<double>(std::min(rule.locked, triangles));
  double target = static_cast<double>(triangles);
  do {
    target = stepFrom(target, locked, factor);
    if (target < kMaxLodTriangles + 1.0) targets.push_back(static_cast<size_t>(target));
  } while (target >= static_cast<double>(limit) + 1);
  return targets;
}

std::vector<size_t> farLodTargets(size_t triangles, const LodRule& rule) {
  std::vector<size_t> targets;
  if (rule.depth == 0 || rule.original_triangles < kFarLodNodes * rule.triangles_per_node) return targets;
  const size_t limit =
      std::max(rule.triangles_per_node / kFarLodShare, kFarLodTrianglesPerLocked * rule.locked);
  const auto locked = static_cast<double>(std::min(rule.locked, triangles));
  auto target = static_cast<double>(triangles);
  while (target >= static_cast<double>(limit) + 1) {
    target = stepFrom(target, locked, 0.5);
    targets.push_back(static_cast<size_t>(target));
  }
  return targets;
}

}  // namespace lode::ingest
