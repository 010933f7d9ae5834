#include "client/render/draw_counts.h"

#include <algorithm>

namespace lode::render {

DrawCounts& DrawCounts::operator+=(const DrawCounts& more) noexcept {
  triangles += more.triangles;
  nodes += more.nodes;
  calls += more.calls;
  error_px = std::max(error_px, more.error_px);
  shown += more.shown;
  return *this;
}

}  // namespace lode::render
