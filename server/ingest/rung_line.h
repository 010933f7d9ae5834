#pragma once

#include <deque>
#include <functional>
#include <future>
#include <span>

#include "server/ingest/finished_rung.h"

namespace lode::ingest {

/// Finishes the rungs of one node and hands them on in the order in which they were pushed. Where threads are
/// idle, as they are near the root, several are finished at once beside the caller, who goes on simplifying.
class RungLine {
 public:
  using Sink = std::function<void(FinishedRung&&)>;

  /// @param input, samples, step_model  as for finishRung(); they must outlive the line. @param helpers  how
  /// many rungs may be under way at once; with none, push() does all itself. @param sink  called by push()
  /// and finish().
  RungLine(const RungInput& input, std::span<const SurfaceSample> samples, double step_model,
           unsigned helpers, Sink sink);

  /// Throws what finishing an earlier rung has thrown, as finish() does.
  void push(SimplifiedMesh&& rung);
  /// Returns when all are handed on.
  void finish();

 private:
  void handOnOldest();

  const RungInput& input_;
  const std::span<const SurfaceSample> samples_;
  const double step_model_;
  const unsigned helpers_;
  const Sink sink_;
  std::deque<std::future<FinishedRung>> under_way_;  ///< each waits for its thread when it goes
};

}  // namespace lode::ingest
