#include "server/ingest/nodes/rung_targets.h"

#include <algorithm>
#include <cmath>

#include "common/limits.h"

namespace lode::ingest {

namespace {

constexpr int kFineStepDepth = 2;
constexpr uint64_t kFineStepNodes = 16;  ///< node budgets that must lie below a node for fine steps
constexpr size_t kTrianglesPerLocked = 8;
constexpr size_t kTrianglesPerLockedOfLarge = 4;  ///< for more than
constexpr size_t kLargeTriangles = 1 << 17;       ///< so that a parent's input stays below some million
constexpr double kInnerFactor = 2.0 / 3;  ///< by which what locked vertices do not hold may fall further

/// Where a node's rungs end.
size_t enoughOf(const RungRule& rule) {
  if (rule.depth == 0) return kRootTriangles;
  const size_t roomy = std::min(kTrianglesPerLocked * rule.locked, kLargeTriangles);
  const size_t least = std::max({rule.triangles_per_node, roomy, kTrianglesPerLockedOfLarge * rule.locked});
  return std::min<size_t>(least, kMaxRungTriangles);
}

}  // namespace

std::vector<size_t> rungTargets(size_t triangles, const RungRule& rule) {
  const bool is_root = rule.depth == 0;
  const size_t enough = enoughOf(rule);
  const bool is_large = rule.original_triangles >= kFineStepNodes * rule.triangles_per_node;
  const double factor = is_root || (rule.depth <= kFineStepDepth && is_large) ? std::sqrt(0.5) : 0.5;
  std::vector<size_t> targets;
  if (rule.is_leaf && triangles <= enough) return targets;
  const auto held = static_cast<double>(std::min(rule.locked, triangles));
  double target = static_cast<double>(triangles);
  do {
    target = std::max(factor * target, held + factor * kInnerFactor * (target - held));
    if (target < kMaxRungTriangles + 1.0) targets.push_back(static_cast<size_t>(target));
  } while (target >= static_cast<double>(enough) + 1);
  return targets;
}

}  // namespace lode::ingest
