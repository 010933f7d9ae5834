#include "server/ingest/build/idle_rungs.h"

#include <cstddef>
#include <cstdint>

namespace lode::ingest {
namespace {

constexpr uint32_t kLargeTriangles = 1 << 19;  ///< a gyroid of 10 million, with 454,176, gains nothing
constexpr float kFartherSibling = 2;           ///< as many times as far from the eye as the nearest

}  // namespace

void leaveOutIdleRungs(FinishedNode& finished, const Node& parent) {
  Node& node = finished.node;
  const Rung& finest = parent.rungs.front();
  const float most = (finest.triangles < kLargeTriangles ? 1 : kFartherSibling) * finest.offModel();
  while (node.spare_rungs > 1) {
    const auto finer = static_cast<std::ptrdiff_t>(node.rungs.size()) - 2;
    if (node.rungs[finer].offModel() <= most) return;
    node.rungs.erase(node.rungs.begin() + finer);
    finished.payloads.erase(finished.payloads.begin() + finer);
    --node.spare_rungs;
  }
}

}  // namespace lode::ingest
