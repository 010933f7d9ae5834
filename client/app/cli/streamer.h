#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "client/app/cli/target.h"
#include "client/core/cut.h"
#include "client/core/engine.h"
#include "client/core/view.h"

namespace lode::app {

struct StreamOptions {
  std::string token;
  uint64_t memory_budget_bytes = core::kDefaultMemoryBudgetBytes;
  uint64_t triangle_budget = std::numeric_limits<uint64_t>::max();
  std::chrono::milliseconds connect_timeout{10'000};
  unsigned decode_threads = 0;  ///< 0: as many as there are cores but two, at least one
};

/// What the last step of a stream has left.
struct StreamStatus {
  std::shared_ptr<const core::Cut> cut;  ///< null until there is something to show
  uint64_t cut_blob_bytes = 0;           ///< of the blobs that the cut is made of
  core::EngineCounts counts;
  bool limited = false;  ///< a budget keeps the cut from converging
  bool settled = false;  ///< the cut is all that the view and the budgets will ever give
  std::string failure;   ///< why the stream has ended or a part cannot be had; empty while all is well
  bool ended = false;    ///< nothing more will come
};

/// A model streamed from a server: transport, refine thread and decode pool around a core::Engine. All
/// threads are joined by the destructor. Thread safe.
class Streamer {
 public:
  /// Starts to connect.
  Streamer(ServedModel model, StreamOptions options);
  ~Streamer();
  Streamer(const Streamer&) = delete;
  Streamer& operator=(const Streamer&) = delete;

  /// Waits until the model is open. @throws Error if it cannot be, kTimeout after the time.
  const ModelSummary& waitForModel(std::chrono::milliseconds timeout);
  /// Refines for this view from now on; never waits for the network.
  void setView(const core::View& view, float threshold_px);
  /// Never waits for the network.
  StreamStatus status() const;
  /// Waits until the cut for the view last set has converged, cannot, or the time is over.
  StreamStatus waitForConvergence(std::chrono::milliseconds timeout);
  /// Waits for the first cut for the view last set, or the end.
  StreamStatus waitForCut(std::chrono::milliseconds timeout);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::app
