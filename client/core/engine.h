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

constexpr uint64_t kDefaultMemoryBudgetBytes = 1ull << 30;
/// Largest total size of the arrivals that wait for takeArrivals(). Further blobs are not cached.
constexpr uint64_t kMaxArrivalBytes = 16ull << 20;

struct EngineOptions {
  SessionOptions session;
  RefineOptions refine;
  /// Memory for the hierarchy, blobs in transit, meshes and textures.
  uint64_t memory_budget_bytes = kDefaultMemoryBudgetBytes;
  uint32_t jitter_seed = 0;  ///< seed of the random waits between connection attempts
  /// True if the caller has a blob cache and answers takeCacheQueries(). Only blobs that the cache lacks are
  /// then requested from the server.
  bool has_cache = false;
  /// Summary of the model that an earlier run stored in the cache, if any.
  std::optional<ModelSummary> cached_model = std::nullopt;
  bool offline = false;   ///< the engine shows cached_model from the cache and never connects
  bool prefetch = false;  ///< the engine requests blobs ahead of a moving camera
  /// If false, all requests have the same class and priority, so that the server answers them in the order
  /// sent. Benchmarks use this order as baseline.
  bool best_first = true;
  /// Called when a connection breaks, before the session's open requests are dropped; may be empty.
  /// @param is_last  true if the engine does not reconnect and throws `why` next.
  std::function<void(SessionRole role, const Error& why, bool is_last)> on_broken = nullptr;
  /// Called when a server rejects the connection because the server is full or shuts down; may be empty.
  std::function<void(const ServerLeaving& why)> on_turned_away = nullptr;
  /// Called when the server refuses a blob; may be empty.
  std::function<void(const BlobRef& blob, const std::string& why)> on_refused = nullptr;
};

/// Reason why the cut of a view has not converged.
enum class Waiting : size_t {
  kNot,     ///< the cut has converged, or no view is set
  kLink,    ///< the cut waits for a connection or for bytes from the server or the cache
  kDecode,  ///< the cut waits until received blobs are decoded
  kBudget,  ///< an exhausted budget prevents further refinement
};
constexpr size_t kWaitings = 4;

/// Total waiting time by reason.
class WaitTimes {
 public:
  using Duration = std::chrono::nanoseconds;

  /// Adds the time between this call and the next to the total of `waiting`.
  void begin(Waiting waiting, TimePoint now) noexcept {
    if (begun_) times_[static_cast<size_t>(waiting_)] += now - since_;
    begun_ = true;
    waiting_ = waiting;
    since_ = now;
  }
  Duration of(Waiting waiting) const noexcept { return times_[static_cast<size_t>(waiting)]; }
  /// Adds the totals of another model.
  WaitTimes& operator+=(const WaitTimes& other) noexcept {
    for (size_t i = 0; i < kWaitings; ++i) times_[i] += other.times_[i];
    return *this;
  }
  bool operator==(const WaitTimes&) const = default;

 private:
  std::array<Duration, kWaitings> times_{};
  bool begun_ = false;
  Waiting waiting_ = Waiting::kNot;
  TimePoint since_{};
};

/// Statistics of the stream of one model. operator+= adds up the statistics of several models.
struct EngineCounts {
  uint64_t received_bytes = 0;  ///< all bytes received from the server
  uint64_t cache_bytes = 0;     ///< size of the blobs read from the cache
  uint64_t open_requests = 0;
  RequestCounts requests;       ///< numbers of open requests by class
  uint64_t decoding = 0;        ///< number of blobs that wait to be decoded or are being decoded
  uint64_t transit_bytes = 0;   ///< size of requested and undecoded blobs, plus the decoders' memory
  uint64_t resident_bytes = 0;  ///< memory of the decoded meshes
  uint64_t wanted_bytes = 0;    ///< memory that the views need: see ViewGroup::wantedBytes()
  uint64_t known_nodes = 0;
  uint64_t hierarchy_bytes = 0;     ///< memory of the known nodes
  uint64_t texture_blob_bytes = 0;  ///< size of the received texture set and tiles
  uint64_t texture_bytes = 0;       ///< memory of the decoded tiles
  uint64_t tiles = 0;               ///< number of resident tiles
  uint64_t tiles_left_out = 0;      ///< number of needed tiles that do not fit the texture budget
  PrefetchCounts prefetch;
  WaitTimes waited;             ///< waiting time before convergence, by reason
  double link_bytes_per_s = 0;  ///< measured throughput of the link; 0: unknown
  double round_trip_ms = 0;     ///< smallest measured round trip; 0: unknown
  uint64_t window_bytes = 0;    ///< unacknowledged bytes that the server may send

  /// Adds the counts of another model. The round trip becomes the larger of the two round trips.
  EngineCounts& operator+=(const EngineCounts& other) noexcept;
  bool operator==(const EngineCounts&) const = default;
};

/// The client's state machine: a connection, a model and its views. The caller passes in received bytes,
/// cached blobs, decode results and cameras, and gets bytes to send, cache queries, decode jobs and cuts. The
/// engine queries the cache before the server. The model and the last cut outlive the connection. The engine
/// uses no thread, clock or socket of its own. It is not thread safe, but any thread may read the published
/// cuts.
class Engine {
 public:
  explicit Engine(EngineOptions options);

  /// Returns true if the caller should open a connection and then call connect(). If there is an active
  /// connection, connect() makes it the draining connection.
  bool wantsConnection(TimePoint now) const noexcept { return !options_.offline && connection_.due(now); }
  void connect(TimePoint now);
  /// Returns true if there is a connection in this role; if not, the caller should close its transport.
  bool connected(SessionRole role = SessionRole::kActive) const noexcept {
    return connection_.session(role) != nullptr;
  }
  /// Returns true if the active connection accepts requests, because its server is not shutting down.
  bool staysConnected() const noexcept { return connection_.takesRequests(); }
  /// Returns the number of open requests of a connection, including cancelled requests that are not
  /// acknowledged yet.
  uint64_t openRequests(SessionRole role) const noexcept {
    const Session* const session = connection_.session(role);
    return session ? session->openRequests() : 0;
  }
  /// Reports that the transport failed. @throws `why` if reconnecting cannot help; the last cut stays valid.
  void disconnect(const Error& why, TimePoint now, SessionRole role = SessionRole::kActive);
  /// Returns the reason for the missing connection while the engine reconnects; empty otherwise.
  const std::string& trouble() const noexcept { return connection_.trouble(); }
  /// Returns the remedy for the trouble; kNone if there is no trouble.
  Remedy troubleRemedy() const noexcept { return connection_.troubleRemedy(); }

  /// Returns false while received frames wait for a call of takeOutgoing(): see Session::takesInput().
  bool takesInput(SessionRole role = SessionRole::kActive) const noexcept {
    const Session* const session = connection_.session(role);
    return session == nullptr || session->takesInput();
  }
  /// Takes received bytes, or continues with frames that wait. Requires takesInput(), unless `bytes` is
  /// empty.
  /// @throws Error as Session does. Do not use the engine after an error; the last cut stays valid.
  void receive(std::span<const std::byte> bytes, TimePoint now, SessionRole role = SessionRole::kActive);
  void finishDecode(DecodeResult result);
  /// @param view  camera in the model frame; toView() in camera_path.h converts true coordinates.
  void setView(const View& view, float threshold_px) { setViews({&view, 1}, threshold_px); }
  /// Sets one view per instance of the model. All views must have the same picture size.
  void setViews(std::span<const View> views, float threshold_px) { group_.setViews(views, threshold_px); }

  /// Replaces memory_budget_bytes and refine.drawn_budget_bytes of the options.
  void setMemoryBudget(uint64_t bytes, uint64_t drawn_bytes);

  /// Refines if anything has changed, renews the requests and keeps the connections alive. @throws an error
  /// if reconnecting cannot help, as disconnect() does.
  void step(TimePoint now);

  proto::Bytes takeOutgoing(SessionRole role = SessionRole::kActive);
  std::vector<DecodeJob> takeDecodeJobs();

  /// Returns the blobs to look up in the cache. The caller answers each with finishCacheQuery().
  std::vector<BlobRef> takeCacheQueries() { return queries_.take(); }
  /// @param bytes  bytes that match the blob's digest; nothing if the cache does not contain the blob.
  void finishCacheQuery(const BlobRef& blob, std::optional<std::vector<std::byte>> bytes);
  struct Arrival {
    BlobRef blob;
    std::vector<std::byte> bytes;
  };
  /// Returns blobs received from the server, for the caller to cache, at most kMaxArrivalBytes at once; none
  /// if has_cache is false.
  std::vector<Arrival> takeArrivals();
  /// Returns true if the engine is offline and has nothing left to do: the cache has answered all queries,
  /// and no blob waits to be decoded.
  bool exhausted() const noexcept;

  /// Returns the summary of the model; null until the model is open.
  const ModelSummary* summary() const noexcept { return model_ ? &model_->summary() : nullptr; }
  /// Returns the last published cut; null until the root's coarsest LOD is resident and a view is set.
  const std::shared_ptr<const Cut>& cut() const noexcept { return group_.cut(); }
  /// Returns the last cuts, indexed by view: see ViewGroup.
  const std::shared_ptr<const ViewCuts>& viewCuts() const noexcept { return group_.viewCuts(); }
  uint64_t cutBuild() const noexcept { return group_.cutBuild(); }
  bool limited() const noexcept { return group_.limited(); }
  /// Returns true if the cuts are final: they are complete, or their missing blobs cannot be loaded. The
  /// result becomes false when a postponed blob is requested again.
  bool settled() const noexcept;
  /// Returns the reason why a part of the model cannot be loaded; empty if no part has failed.
  const std::string& failure() const noexcept;
  /// Returns true if parts have failed, and the engine will request all of them again.
  bool failureMayPass() const noexcept;
  EngineCounts counts() const noexcept;

 private:
  void handleAll(SessionRole role);
  void handle(ModelOpened event);
  void handle(ModelsListed event);
  void handle(BlobArrived event);
  void handle(BlobRefused event);
  void handle(RequestCancelled event);
  void handle(ServerLeaving event);
  void handle(ModelChanged event);
  void keepArrival(const BlobRef& blob, const std::vector<std::byte>& bytes);
  void deliver(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes);
  void renewRequests();
  Waiting waiting() const noexcept;

  EngineOptions options_;
  Connection connection_;
  CacheQueries queries_;
  std::vector<Arrival> arrivals_;
  uint64_t arrival_bytes_ = 0;  // total size of arrivals_
  uint64_t cache_bytes_ = 0;
  std::optional<Model> model_;
  ViewGroup group_;
  Prefetcher prefetcher_;
  WaitTimes waited_;
  TimePoint now_{};
  bool requests_waiting_ = false;  // renewRequests() may be able to send more requests
  bool held_back_ = false;         // some requests wait until received blobs are decoded
};

}  // namespace lode::core
