#include "server/ingest/rung_line.h"

#include <utility>

namespace lode::ingest {

RungLine::RungLine(const RungInput& input, std::span<const SurfaceSample> samples, double step_model,
                   unsigned helpers, Sink sink)
    : input_(input), samples_(samples), step_model_(step_model), helpers_(helpers), sink_(std::move(sink)) {}

void RungLine::push(SimplifiedMesh&& rung) {
  if (helpers_ == 0) return sink_(finishRung(std::move(rung), input_, samples_, step_model_));
  if (under_way_.size() == helpers_) handOnOldest();
  under_way_.push_back(std::async(std::launch::async, [this, rung = std::move(rung)]() mutable {
    return finishRung(std::move(rung), input_, samples_, step_model_);
  }));
}

void RungLine::finish() {
  while (!under_way_.empty()) handOnOldest();
}

void RungLine::handOnOldest() {
  std::future<FinishedRung> oldest = std::move(under_way_.front());
  under_way_.pop_front();
  sink_(oldest.get());
}

}  // namespace lode::ingest
