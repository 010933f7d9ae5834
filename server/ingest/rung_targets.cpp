#include "server/ingest/rung_targets.h"

#include <algorithm>
#include <cmath>

namespace lode::ingest {

std::vector<size_t> rungTargets(size_t triangles, size_t locked, int depth, size_t triangles_per_node) {
  const size_t enough = depth == 0 ? kRootTriangles : std::max(triangles_per_node, 4 * locked);
  const double factor = depth <= 2 ? std::sqrt(0.5) : 0.5;
  std::vector<size_t> targets;
  if (depth == 0 && triangles <= enough) return targets;
  double target = static_cast<double>(triangles);
  do {
    target *= factor;
    targets.push_back(static_cast<size_t>(target));
  } while (targets.back() > enough);
  return targets;
}

}  // namespace lode::ingest
