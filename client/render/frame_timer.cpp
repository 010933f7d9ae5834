#include "client/render/frame_timer.h"

namespace lode::render {

FrameTimer::FrameTimer() {
  for (Pending& frame : ring_) frame.query = GlTimeQuery::create();
}

std::optional<uint64_t> FrameTimer::begin() {
  timing_ = begun_ - taken_ < ring_.size();
  if (!timing_) return std::nullopt;
  Pending& next = ring_[begun_ % ring_.size()];
  next.frame = {.number = begun_, .coarsening = std::nullopt};
  glBeginQuery(GL_TIME_ELAPSED, next.query.get());
  return begun_;
}

void FrameTimer::end(double cpu_ms, std::optional<Coarsening> coarsening) {
  if (!timing_) return;
  glEndQuery(GL_TIME_ELAPSED);
  Timed& ended = ring_[begun_++ % ring_.size()].frame;
  ended.cpu_ms = cpu_ms;
  ended.coarsening = coarsening;
  timing_ = false;
}

std::optional<FrameTimer::Timed> FrameTimer::take() {
  if (taken_ == begun_) return std::nullopt;
  Pending& oldest = ring_[taken_ % ring_.size()];
  GLint available = 0;
  glGetQueryObjectiv(oldest.query.get(), GL_QUERY_RESULT_AVAILABLE, &available);
  if (available == 0) return std::nullopt;
  GLuint64 ns = 0;
  glGetQueryObjectui64v(oldest.query.get(), GL_QUERY_RESULT, &ns);
  oldest.frame.gpu_ms = static_cast<double>(ns) * 1e-6;
  ++taken_;
  return oldest.frame;
}

void FrameTimer::wait() { glFinish(); }

}  // namespace lode::render
