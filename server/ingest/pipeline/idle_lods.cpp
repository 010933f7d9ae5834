#include "server/ingest/pipeline/idle_lods.h"

#include <cstddef>
#include <cstdint>

namespace lode::ingest {
namespace {

constexpr uint32_t kLargeTriangles = 1 << 19;  ///< a gyroid of 10 million, with 454,176, gains nothing
constexpr float kFartherSibling = 2;           ///< as many times as far from the eye as the nearest

}  // namespace

void leaveOutIdleLods(FinishedNode& finished, const Node& parent) {
  Node& node = finished.node;
  const Lod& finest = parent.lods.front();
  const float most = (finest.triangles < kLargeTriangles ? 1 : kFartherSibling) * finest.offModel();
  while (node.far_lods > 1) {
    const auto finer = static_cast<std::ptrdiff_t>(node.lods.size()) - 2;
    if (node.lods[finer].offModel() <= most) return;
    node.lods.erase(node.lods.begin() + finer);
    finished.payloads.erase(finished.payloads.begin() + finer);
    --node.far_lods;
  }
}

}  // namespace lode::ingest
