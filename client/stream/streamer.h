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

namespace lode::stream {

struct StreamOptions {
  /// The streamer fills in the model's name, jitter_seed, has_cache and cached_model.
  core::EngineOptions engine;
  std::filesystem::path ca_file;  ///< trusted certificate authorities for TLS, in PEM; empty: the system's
  std::chrono::milliseconds connect_timeout{20'000};
  std::filesystem::path cache_folder;  ///< empty: no cache; required if engine.offline
  uint64_t cache_bytes = kDefaultCacheBytes;
  unsigned decode_threads = 0;  ///< 0: defaultDecodeThreads()
};

/// How the server of a model is reached. @throws Error kUsage as net::trustAuthorities().
net::Route routeTo(const ServedModel& model, const StreamOptions& options);

/// What the last step of a stream has left.
struct StreamStatus {
  std::shared_ptr<const core::Cut> cut;             ///< null until there is something to show
  std::shared_ptr<const core::ViewCuts> view_cuts;  ///< by view, whose meshes `cut` has: see core::ViewGroup
  uint64_t cut_build = 0;  ///< names the build that it is of: another one after the model was replaced
  core::EngineCounts counts;
  bool limited = false;    ///< a budget keeps the cut from converging
  bool settled = false;    ///< the cut is all that the view and the budgets will ever give
  bool exhausted = false;  ///< offline, and the cache does not have the rest of what the view needs
  std::string failure;     ///< why the stream has ended or a part cannot be had; empty while all is well
  std::string trouble;     ///< why there is no connection, while a new one is tried for; empty otherwise
  bool ended = false;      ///< nothing more will come
  bool current = false;    ///< it is about the view last set
};

/// A model streamed from a server: transport, refine thread and decode pool around a core::Engine. Connects
/// anew when the connection ends, while the last cut stays. All threads are joined by the destructor. Thread
/// safe.
class Streamer {
 public:
  /// Starts to connect. @throws Error as DecodePool(), kIo if the system gives no thread.
  Streamer(ServedModel model, StreamOptions options);
  ~Streamer();
  Streamer(const Streamer&) = delete;
  Streamer& operator=(const Streamer&) = delete;

  /// Waits until the model is open. @throws Error if it cannot be, kTimeout after the time or when it is
  /// stopped.
  const ModelSummary& waitForModel(std::chrono::milliseconds timeout, std::stop_token stop = {});
  /// Refines for this view from now on; never waits for the network.
  void setView(const core::View& view, float threshold_px) { setViews({&view, 1}, threshold_px); }
  /// The same for a model that stands in several places: see core::Engine.
  void setViews(std::span<const core::View> views, float threshold_px);
  /// Others than the options', from now on: see core::Engine.
  void setMemoryBudget(uint64_t bytes, uint64_t drawn_bytes);
  /// Cuts made of the stream's: freed on its thread when nobody else has them, as its own are.
  void keep(std::vector<std::shared_ptr<const core::Cut>> cuts);
  /// Never waits for the network.
  StreamStatus status() const;
  /// What is known of the model; nothing until it is open.
  std::optional<ModelSummary> model() const;
  /// Waits until there is news since the last call, or the time is over: the model is open, the view last set
  /// was refined, another cut, whether it is limited or settled, a failure, trouble or its end. A view set
  /// again that has settled is news, too.
  StreamStatus waitForNews(std::chrono::milliseconds timeout);
  /// Waits until the cut for the view last set has converged, cannot, or the time is over. Parts that are not
  /// seen may be missing.
  StreamStatus waitForConvergence(std::chrono::milliseconds timeout);
  /// Waits until the cut for the view last set has settled, cannot, or the time is over.
  StreamStatus waitUntilSettled(std::chrono::milliseconds timeout);
  /// Waits for the first cut for the view last set, or the end.
  StreamStatus waitForCut(std::chrono::milliseconds timeout);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::stream
