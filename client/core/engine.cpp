#include "client/core/engine.h"

#include <algorithm>
#include <unordered_set>
#include <utility>
#include <variant>

#include "common/error.h"

namespace lode::core {

Engine::Engine(EngineOptions options)
    : options_(std::move(options)),
      connection_(options_.session, options_.jitter_seed),
      group_(options_.refine) {
  if (options_.offline && options_.cached_model)
    model_.emplace(*options_.cached_model, options_.memory_budget_bytes);
  requests_waiting_ = model_.has_value();
}

void Engine::setMemoryBudget(uint64_t bytes, uint64_t drawn_bytes) {
  if (options_.memory_budget_bytes == bytes && options_.refine.drawn_budget_bytes == drawn_bytes) return;
  options_.memory_budget_bytes = bytes;
  options_.refine.drawn_budget_bytes = drawn_bytes;
  if (model_) model_->setMemoryBudget(bytes);
  group_.setDrawnBudget(drawn_bytes);
}

void Engine::connect(TimePoint now) {
  const ModelSummary* const known = model_                  ? &model_->summary()
                                    : options_.cached_model ? &*options_.cached_model
                                                            : nullptr;
  connection_.begin(known ? known->build_id : Digest(), now);
}

void Engine::receive(std::span<const std::byte> bytes, TimePoint now, SessionRole role) {
  now_ = now;
  if (!connection_.session(role)) return;
  connection_.session(role)->receive(bytes, now);
  handleAll(role);
}

void Engine::handleAll(SessionRole role) {
  while (connection_.session(role)) {
    std::optional<SessionEvent> event = connection_.session(role)->nextEvent();
    if (!event) return;
    // Ignore these notices on the draining connection: the active connection gets its own.
    const bool is_heard = role == SessionRole::kActive || !(std::holds_alternative<ServerLeaving>(*event) ||
                                                            std::holds_alternative<ModelChanged>(*event));
    if (is_heard) std::visit([this](auto taken) { handle(std::move(taken)); }, std::move(*event));
  }
}

void Engine::disconnect(const Error& why, TimePoint now, SessionRole role) {
  if (options_.on_broken && connection_.session(role))
    options_.on_broken(role, why, role == SessionRole::kActive && !connection_.survives(why, now));
  requests_waiting_ = true;
  if (role == SessionRole::kActive) return connection_.fail(why, now);
  connection_.endDraining();
}

void Engine::handle(ModelOpened event) {
  connection_.succeeded();
  requests_waiting_ = true;
  if (model_ && model_->summary().build_id == event.summary.build_id) return;
  if (model_ && group_.cut() && model_->summary().lattice != event.summary.lattice)
    throw Error(ErrorCode::kInput,
                "the server has replaced the model by one of another size or position; open it again");
  model_.emplace(std::move(event.summary), options_.memory_budget_bytes);
  group_.forgetModel();
  prefetcher_.forgetModel();
  queries_ = {};
  connection_.endDraining();
}

void Engine::handle(ModelsListed) {
  throw Error(ErrorCode::kInternal, "an engine opens a model; it asked for no list");
}

void Engine::handle(BlobArrived event) {
  queries_.arrived(event.blob);
  if (options_.has_cache) keepArrival(event.blob, event.bytes);
  const bool was_root_page = event.use.kind == BlobKind::kRootPage;
  deliver(event.blob, event.use, std::move(event.bytes));
  if (!was_root_page || !connection_.session() || !connection_.session()->givesFirstBlobs()) return;
  if (const auto coarsest = model_->firstRequest())
    connection_.session()->expectUnasked(coarsest->blob, coarsest->use);
}

void Engine::keepArrival(const BlobRef& blob, const std::vector<std::byte>& bytes) {
  if (arrival_bytes_ + bytes.size() > kMaxArrivalBytes) return;
  arrival_bytes_ += bytes.size();
  arrivals_.push_back({blob, bytes});
}

std::vector<Engine::Arrival> Engine::takeArrivals() {
  arrival_bytes_ = 0;
  return std::exchange(arrivals_, {});
}

void Engine::deliver(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes) {
  prefetcher_.arrived(blob, use);
  // Several LODs may share a payload, which is requested only once, so deliver it for each of them.
  for (const Request& request : group_.requests())
    if (request.blob == blob && request.use != use) model_->take(request.blob, request.use, bytes);
  model_->take(blob, use, std::move(bytes));
}

void Engine::finishCacheQuery(const BlobRef& blob, std::optional<std::vector<std::byte>> bytes) {
  const auto use = queries_.finish(blob, bytes.has_value());
  requests_waiting_ = true;
  if (!use || !bytes) return;
  cache_bytes_ += bytes->size();
  deliver(blob, *use, std::move(*bytes));
}

bool Engine::exhausted() const noexcept {
  return options_.offline && queries_.idle() && !requests_waiting_ && (!model_ || model_->decoding() == 0);
}

bool Engine::settled() const noexcept {
  if (group_.settled()) return true;
  if (!model_ || model_->failure().empty() || requests_waiting_ || model_->decoding() != 0 ||
      !queries_.idle())
    return false;
  return !model_->firstRequest() && std::ranges::none_of(group_.requests(), [this](const Request& request) {
    return model_->wants(request);
  });
}

void Engine::handle(BlobRefused event) {
  if (options_.on_refused) options_.on_refused(event.blob, event.message);
  const std::string why = "the server says: " + event.message;
  if (event.is_lost) return model_->lose(event.blob, why);
  model_->postpone(event.blob, why, now_);
}

void Engine::handle(RequestCancelled) { requests_waiting_ = true; }

void Engine::handle(ServerLeaving event) {
  if (options_.on_turned_away && !connection_.session()->opened()) options_.on_turned_away(event);
  connection_.leave(std::move(event.reason), now_, event.remedy);
}

void Engine::handle(ModelChanged) { connection_.restart(now_); }

void Engine::finishDecode(DecodeResult result) {
  if (model_) model_->finishDecode(std::move(result));
}

void Engine::step(TimePoint now) {
  now_ = now;
  for (const SessionRole role : kSessionRoles) {
    if (!connection_.session(role)) continue;
    try {
      connection_.session(role)->tick(now);
    } catch (const Error& silent) {
      disconnect(silent, now, role);
    }
  }
  if (model_) {
    requests_waiting_ |= model_->releasePostponed(now);
    bool changed = group_.refine(*model_);
    if (changed) prefetcher_.needed(group_.viewCuts().get(), group_.pages(), group_.requests());
    if (options_.prefetch) {
      prefetcher_.setViewCount(group_.viewCount());
      for (size_t number = 0; number < group_.viewCount(); ++number)
        prefetcher_.record(number, group_.view(number), now);
      changed |= prefetcher_.lookAhead(*model_, group_.options(), now);
    }
    if (changed || requests_waiting_) renewRequests();
  }
  waited_.begin(waiting(), now);
}

Waiting Engine::waiting() const noexcept {
  if (!model_ || !model_->hierarchy().root()) return Waiting::kLink;
  if (group_.viewCount() == 0 || (cut() && cut()->converged)) return Waiting::kNot;
  const auto isSeen = [](const Request& request) {
    return request.request_class == proto::RequestClass::kVisible;
  };
  const std::vector<Request>& requests = group_.requests();
  const auto seen_end = std::find_if_not(requests.begin(), requests.end(), isSeen);
  if (seen_end == requests.begin()) return group_.limited() ? Waiting::kBudget : Waiting::kNot;
  if (held_back_) return Waiting::kDecode;
  const bool is_awaited = std::any_of(requests.begin(), seen_end,
                                      [this](const Request& request) { return model_->wants(request); });
  return is_awaited ? Waiting::kLink : Waiting::kDecode;
}

void Engine::renewRequests() {
  requests_waiting_ = held_back_ = false;
  if (!connection_.session() && !options_.has_cache) return;
  std::vector<Request> requests;
  std::unordered_set<uint32_t> asked;  // blob numbers of requests already handled
  const Session* const draining = connection_.session(SessionRole::kDraining);
  const uint64_t budget_bytes = model_->transitBudgetBytes();
  uint64_t waiting_bytes = model_->undecodedBytes();
  /// @return false if no further request fits.
  const auto ask = [&](const Request& request) {
    // Load stand-ins only after the cache has missed a blob, which the server must then send.
    if (request.is_stand_in && options_.has_cache && !queries_.hasMisses()) return true;
    if (!model_->wants(request) || !asked.insert(request.blob.number).second) return true;
    if (draining != nullptr && draining->isRequested(request.blob)) return true;
    waiting_bytes += request.blob.bytes;
    held_back_ = waiting_bytes > budget_bytes && model_->undecodedBytes() > budget_bytes / 2;
    if (waiting_bytes > budget_bytes && !(requests.empty() && model_->decoding() == 0)) return false;
    if (request.request_class == proto::RequestClass::kPrefetch) prefetcher_.asked(request);
    if (!options_.has_cache || queries_.isMissing(request, budget_bytes)) requests.push_back(request);
    return requests.size() < kMaxRequestsAtOnce;
  };
  if (const auto first = model_->firstRequest()) ask(*first);
  // Prefetch nothing while the picture is far too coarse, because visible blobs come first.
  const bool is_far_off = isFarOff(cut().get(), group_.options().threshold_px);
  const std::span<const Request> ahead =
      is_far_off ? std::span<const Request>() : std::span(prefetcher_.requests());
  for (const Request& request : group_.requests())
    if (!ask(request)) break;
  for (const Request& request : ahead)
    if (!ask(request)) break;
  if (!options_.best_first) {
    for (Request& request : requests) {
      request.request_class = proto::RequestClass::kVisible;
      request.priority_px = 1;
    }
  }
  if (connection_.takesRequests()) requests_waiting_ = !connection_.session()->setRequests(requests);
}

proto::Bytes Engine::takeOutgoing(SessionRole role) {
  return connection_.session(role) ? connection_.session(role)->takeOutgoing() : proto::Bytes();
}

std::vector<DecodeJob> Engine::takeDecodeJobs() {
  return model_ ? model_->takeDecodeJobs() : std::vector<DecodeJob>();
}

const std::string& Engine::failure() const noexcept {
  static const std::string kNone;
  return model_ ? model_->failure() : kNone;
}

EngineCounts& EngineCounts::operator+=(const EngineCounts& other) noexcept {
  received_bytes += other.received_bytes;
  cache_bytes += other.cache_bytes;
  open_requests += other.open_requests;
  requests += other.requests;
  decoding += other.decoding;
  transit_bytes += other.transit_bytes;
  resident_bytes += other.resident_bytes;
  wanted_bytes += other.wanted_bytes;
  known_nodes += other.known_nodes;
  hierarchy_bytes += other.hierarchy_bytes;
  texture_blob_bytes += other.texture_blob_bytes;
  texture_bytes += other.texture_bytes;
  tiles += other.tiles;
  tiles_left_out += other.tiles_left_out;
  prefetch += other.prefetch;
  waited += other.waited;
  link_bytes_per_s += other.link_bytes_per_s;
  round_trip_ms = std::max(round_trip_ms, other.round_trip_ms);
  window_bytes += other.window_bytes;
  return *this;
}

bool Engine::failureMayPass() const noexcept { return model_ && model_->failureMayPass(); }

EngineCounts Engine::counts() const noexcept {
  EngineCounts counts;
  counts.received_bytes = connection_.receivedBytes();
  counts.cache_bytes = cache_bytes_;
  counts.prefetch = prefetcher_.counts();
  counts.waited = waited_;
  if (const Session* session = connection_.session()) {
    using Milliseconds = std::chrono::duration<double, std::milli>;
    const CreditWindow& window = session->window();
    counts.open_requests = session->openRequests();
    counts.requests = session->requestCounts();
    counts.link_bytes_per_s = window.bytesPerSecond();
    counts.round_trip_ms = Milliseconds(window.roundTrip().value_or(std::chrono::nanoseconds(0))).count();
    counts.window_bytes = window.bytes();
  }
  if (!model_) return counts;
  counts.decoding = model_->decoding();
  counts.transit_bytes = model_->undecodedBytes() + model_->decodingBytes();
  if (connection_.session()) counts.transit_bytes += connection_.session()->requestedBytes();
  counts.resident_bytes = model_->meshes().bytes();
  counts.wanted_bytes = group_.wantedBytes();
  counts.known_nodes = model_->hierarchy().size();
  counts.hierarchy_bytes = model_->hierarchy().bytes();
  counts.texture_blob_bytes = model_->textureBlobBytes();
  if (const TextureStream* textures = model_->textures()) {
    counts.texture_bytes = textures->residentBytes();
    counts.tiles = textures->residentCount();
    counts.tiles_left_out = textures->leftOut();
  }
  return counts;
}

}  // namespace lode::core
