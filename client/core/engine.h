#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/core/cache/cache_queries.h"
#include "client/core/cache/decode_job.h"
#include "client/core/lod/cut.h"
#include "client/core/lod/prefetcher.h"
#include "client/core/lod/refine_options.h"
#include "client/core/lod/view_group.h"
#include "client/core/model.h"
#include "client/core/session/connection.h"
#include "client/core/view/time_point.h"
#include "client/core/view/view.h"
#include "common/error.h"

namespace lode::core {

constexpr uint64_t kDefaultMemoryBudgetBytes = 1ull << 30;  ///< of decoded meshes and textures

struct EngineOptions {
  SessionOptions session;
  RefineOptions refine;  ///< for ViewGroup
  uint64_t memory_budget_bytes = kDefaultMemoryBudgetBytes;
  uint32_t jitter_seed = 0;  ///< of the times between tries to connect
  bool has_cache = false;    ///< takeCacheQueries() is answered: a server is asked for what the cache lacks
  /// Of the model as the cache has it, from an earlier run.
  std::optional<ModelSummary> cached_model = std::nullopt;
  bool offline = false;   ///< shows cached_model from the cache and never wants a connection
  bool prefetch = false;  ///< asks ahead of a camera that moves
  /// False: what is requested comes in the order in which it was requested, to compare with.
  bool best_first = true;
  /// Told of a connection that breaks, and why, while it still has what it had open; may be empty.
  /// @param is_last  the engine does not go on: that error is thrown next.
  std::function<void(Line line, const Error& why, bool is_last)> on_broken = nullptr;
  /// Told of a server that does not let it in, as it is full or going away, and why; may be empty.
  std::function<void(const std::string& why)> on_turned_away = nullptr;
  /// Told of a blob that the server cannot give, and why; may be empty.
  std::function<void(const BlobRef& blob, const std::string& why)> on_refused = nullptr;
};

/// What stands between a view and its converged picture.
enum class Waiting : size_t {
  kNot,     ///< it has converged, or there is no view
  kLink,    ///< bytes are awaited, from the server or for a connection to it
  kDecode,  ///< bytes are there and not decoded yet
  kBudget,  ///< all is there that the memory allows
};
constexpr size_t kWaitings = 4;

/// How long it was waited for what.
class WaitTimes {
 public:
  using Duration = std::chrono::nanoseconds;

  /// From now on, until the next call.
  void begin(Waiting waiting, TimePoint now) noexcept {
    if (begun_) times_[static_cast<size_t>(waiting_)] += now - since_;
    begun_ = true;
    waiting_ = waiting;
    since_ = now;
  }
  Duration of(Waiting waiting) const noexcept { return times_[static_cast<size_t>(waiting)]; }

 private:
  std::array<Duration, kWaitings> times_{};
  bool begun_ = false;
  Waiting waiting_ = Waiting::kNot;
  TimePoint since_{};
};

struct EngineCounts {
  uint64_t received_bytes = 0;  ///< everything from the server
  uint64_t cache_bytes = 0;     ///< of blobs from the cache
  uint64_t open_requests = 0;
  RequestCounts requests;       ///< the same
  uint64_t decoding = 0;        ///< jobs handed out
  uint64_t transit_bytes = 0;   ///< asked for, not decoded, or being decoded, with what decoding takes
  uint64_t resident_bytes = 0;  ///< decoded meshes
  uint64_t wanted_bytes = 0;    ///< of them for the error asked for: see ViewGroup::wantedBytes()
  uint64_t known_nodes = 0;
  uint64_t hierarchy_bytes = 0;     ///< of the known nodes
  uint64_t texture_blob_bytes = 0;  ///< received for textures: their set and tiles
  uint64_t texture_bytes = 0;       ///< decoded tiles
  uint64_t tiles = 0;               ///< resident
  uint64_t tiles_left_out = 0;      ///< that the view needs and the memory budget does not allow
  PrefetchCounts prefetch;
  WaitTimes waited;             ///< for the picture to converge
  double link_bytes_per_s = 0;  ///< measured; 0: not yet
  double round_trip_ms = 0;     ///< smallest measured; 0: none yet
  uint64_t window_bytes = 0;    ///< that the server may have under way
};

/// A link to a server, a model and the views of it, stepped together: bytes, blobs from a cache, decoded
/// meshes and tiles and a camera in; bytes, decode jobs and cuts out. Blobs are asked of the cache first. The
/// model and the last cut outlive the connection. Owns no thread, knows no clock and no socket. Not thread
/// safe; the cuts it gives are.
class Engine {
 public:
  explicit Engine(EngineOptions options);

  /// A transport is to be made, and then connect() called. What was the newest until then, if it is there, is
  /// the leaving one from then on.
  bool wantsConnection(TimePoint now) const noexcept { return !options_.offline && connection_.due(now); }
  void connect(TimePoint now);
  /// False: the transport, if there is one, is of no more use.
  bool connected(Line line = Line::kActive) const noexcept { return connection_.session(line) != nullptr; }
  /// There is a connection, and its server does not go away.
  bool staysConnected() const noexcept { return connection_.takesRequests(); }
  /// Those that a connection has open, with those taken back.
  uint64_t openRequests(Line line) const noexcept {
    const Session* const session = connection_.session(line);
    return session ? session->openRequests() : 0;
  }
  /// The transport failed. @throws the error if a new one would not help; the last cut stays good.
  void disconnect(const Error& why, TimePoint now, Line line = Line::kActive);
  /// Why there is no connection now, while a new one is tried for; empty otherwise.
  const std::string& trouble() const noexcept { return connection_.trouble(); }

  /// @throws Error as Session does: the engine must be given up then; the last cut stays good.
  void receive(std::span<const std::byte> bytes, TimePoint now, Line line = Line::kActive);
  void finishDecode(DecodeResult result);
  /// @param view  in the model frame: see camera_path.h for how to come from true coordinates.
  void setView(const View& view, float threshold_px) { setViews({&view, 1}, threshold_px); }
  /// The same for a model that stands in several places. @param views  of pictures of one size.
  void setViews(std::span<const View> views, float threshold_px) { group_.setViews(views, threshold_px); }

  /// Others than the options', from now on: of all, and of what is drawn.
  void setMemoryBudget(uint64_t bytes, uint64_t drawn_bytes);

  /// Refines if anything has changed, renews the requests, keeps the connection alive. @throws Error as
  /// disconnect().
  void step(TimePoint now);

  proto::Bytes takeOutgoing(Line line = Line::kActive);
  std::vector<DecodeJob> takeDecodeJobs();

  /// Blobs to be looked for in the cache; each is to be answered by finishCacheQuery().
  std::vector<BlobRef> takeCacheQueries() { return queries_.take(); }
  /// @param bytes  none: the cache does not have the blob. They must have its name.
  void finishCacheQuery(const BlobRef& blob, std::optional<std::vector<std::byte>> bytes);
  struct Arrival {
    BlobRef blob;
    std::vector<std::byte> bytes;
  };
  /// Blobs that came from the server, for the cache; none without one.
  std::vector<Arrival> takeArrivals() { return std::exchange(arrivals_, {}); }
  /// Nothing more will come: it is offline, and the cache has given what it has.
  bool exhausted() const noexcept;

  /// Null until the model is open.
  const ModelSummary* summary() const noexcept { return model_ ? &model_->summary() : nullptr; }
  /// The last cut published; null until the root's coarsest LOD is there and a view is set.
  const std::shared_ptr<const Cut>& cut() const noexcept { return group_.cut(); }
  /// By view, as those; see ViewGroup.
  const std::shared_ptr<const ViewCuts>& viewCuts() const noexcept { return group_.viewCuts(); }
  uint64_t cutBuild() const noexcept { return group_.cutBuild(); }
  bool limited() const noexcept { return group_.limited(); }
  /// Nothing more will come for the views: their cuts are whole, or what they lack cannot be had.
  bool settled() const noexcept;
  /// Why a part of the model cannot be had; empty if nothing is wrong.
  const std::string& failure() const noexcept;
  EngineCounts counts() const noexcept;

 private:
  void handleAll(Line line);
  void handle(ModelOpened event);
  void handle(ModelsListed event);
  void handle(BlobArrived event);
  void handle(BlobRefused event);
  void handle(RequestCancelled event);
  void handle(ServerLeaving event);
  void handle(ModelChanged event);
  void deliver(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes);
  void renewRequests();
  Waiting waiting() const noexcept;

  EngineOptions options_;
  Connection connection_;
  CacheQueries queries_;
  std::vector<Arrival> arrivals_;
  uint64_t cache_bytes_ = 0;
  std::optional<Model> model_;
  ViewGroup group_;
  Prefetcher prefetcher_;
  WaitTimes waited_;
  TimePoint now_{};
  bool requests_waiting_ = false;  // some may be sent that could not be before
  bool held_back_ = false;         // some may not be sent before others are decoded
};

}  // namespace lode::core
