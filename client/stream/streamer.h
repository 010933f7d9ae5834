#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "client/core/engine.h"
#include "client/core/lod/cut.h"
#include "client/core/view/view.h"
#include "client/net/address.h"
#include "client/stream/blob_cache.h"
#include "client/stream/served_model.h"
#include "common/error.h"

namespace lode::stream {

struct StreamOptions {
  /// Options of the engine. The streamer itself sets the model's name, jitter_seed, has_cache and
  /// cached_model.
  core::EngineOptions engine;
  /// Trusted certificate authorities for TLS, in PEM; empty: the system's authorities.
  std::filesystem::path ca_file;
  std::chrono::milliseconds connect_timeout{20'000};
  /// Folder of the blob cache; if empty, there is no cache. Required if engine.offline is true.
  std::filesystem::path cache_folder;
  uint64_t cache_bytes = kDefaultCacheBytes;
  unsigned decode_threads = 0;  ///< number of decode threads; 0: defaultDecodeThreads()
};

/// Returns the route to the server of a model. @throws Error kUsage as net::trustAuthorities() does.
net::Route routeTo(const ServedModel& model, const StreamOptions& options);

/// State of a stream after its last step.
struct StreamStatus {
  std::shared_ptr<const core::Cut> cut;  ///< current cut; null until a cut is published
  /// Cuts indexed by view; `cut` is their union: see core::ViewCuts.
  std::shared_ptr<const core::ViewCuts> view_cuts;
  uint64_t cut_build = 0;  ///< build of the cut; changes when the model is replaced
  core::EngineCounts counts;
  bool limited = false;    ///< a budget prevents the cut from converging
  bool settled = false;    ///< the cut is final for the view and the budgets
  bool exhausted = false;  ///< the stream is offline, and the cache lacks blobs that the view needs
  std::string failure;     ///< reason why the stream has ended or a part cannot be loaded; empty otherwise
  Remedy failure_remedy = Remedy::kNone;  ///< remedy for the failure
  bool failure_may_pass = false;          ///< the stream will request the missing parts again
  std::string trouble;  ///< reason for the missing connection while the stream reconnects; empty otherwise
  Remedy trouble_remedy = Remedy::kNone;  ///< remedy for the trouble
  bool ended = false;                     ///< the stream has stopped for good
  bool current = false;                   ///< the status describes the view that was set last
};

/// Streams a model from a server, with a core::Engine, a transport, a refinement thread and a decode pool.
/// When the connection ends, reconnects and keeps the last cut. The destructor joins all threads. Thread
/// safe.
class Streamer {
 public:
  /// Starts to connect. @throws Error as DecodePool() does; kIo if no thread can be started.
  Streamer(ServedModel model, StreamOptions options);
  ~Streamer();
  Streamer(const Streamer&) = delete;
  Streamer& operator=(const Streamer&) = delete;

  /// Waits until the model is open. @throws Error if the model cannot be opened; kTimeout after the timeout,
  /// or if `stop` is requested.
  ModelSummary waitForModel(std::chrono::milliseconds timeout, std::stop_token stop = {});
  /// Sets the view to refine for; never blocks on the network.
  void setView(const core::View& view, float threshold_px) { setViews({&view, 1}, threshold_px); }
  /// Sets one view per instance of the model: see core::Engine.
  void setViews(std::span<const core::View> views, float threshold_px);
  /// Replaces the memory and drawn budgets of the options: see core::Engine.
  void setMemoryBudget(uint64_t bytes, uint64_t drawn_bytes);
  /// Keeps references to cuts that the caller has derived from the stream's cuts. When the caller has dropped
  /// its own references to a cut, the stream's thread frees the cut, so that no frame waits: see
  /// PublishedCuts.
  void keep(std::vector<std::shared_ptr<const core::Cut>> cuts);
  /// Returns the last status; never blocks on the network. A status that is not `current` is not settled.
  StreamStatus status() const;
  /// Returns the summary of the model's latest build; nothing until the model is open.
  std::optional<ModelSummary> model() const;
  /// Waits for a change since the last call, at most for the timeout. A change is one of these: the model has
  /// been opened or replaced; the view that was set last has been refined; a new cut was published; limited,
  /// settled, exhausted, failure or trouble has changed; the stream has ended. Setting a settled view again
  /// also counts as a change.
  StreamStatus waitForNews(std::chrono::milliseconds timeout);
  /// Waits until the cut of the view that was set last has converged or cannot converge, at most for the
  /// timeout. Parts outside the view may still be missing.
  StreamStatus waitForConvergence(std::chrono::milliseconds timeout);
  /// Waits until the cut of the view that was set last has settled or cannot settle, at most for the timeout.
  StreamStatus waitUntilSettled(std::chrono::milliseconds timeout);
  /// Waits until there is a cut for the view that was set last or the stream has ended, at most for the
  /// timeout.
  StreamStatus waitForCut(std::chrono::milliseconds timeout);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::stream
