#include "client/core/engine.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "common/error.h"

namespace lode::core {

Engine::Engine(EngineOptions options)
    : options_(std::move(options)),
      link_(options_.session, options_.jitter_seed),
      instance_(options_.triangle_budget, options_.hold_factor) {
  if (options_.offline && options_.cached_model)
    model_.emplace(*options_.cached_model, options_.memory_budget_bytes);
  wishes_waiting_ = model_.has_value();
}

void Engine::connect(TimePoint now) {
  const ModelSummary* const known = model_                  ? &model_->summary()
                                    : options_.cached_model ? &*options_.cached_model
                                                            : nullptr;
  link_.begin(known ? known->build_id : BlobName(), now);
}

void Engine::receive(std::span<const std::byte> bytes, TimePoint now) {
  now_ = now;
  if (!link_.session()) return;
  link_.session()->receive(bytes, now);
  while (link_.session()) {
    std::optional<SessionEvent> event = link_.session()->nextEvent();
    if (!event) return;
    std::visit([this](auto taken) { handle(std::move(taken)); }, std::move(*event));
  }
}

void Engine::handle(ModelOpened event) {
  link_.succeeded();
  wishes_waiting_ = true;
  if (model_ && model_->summary().build_id == event.summary.build_id) return;
  if (model_ && instance_.cut() && model_->summary().lattice != event.summary.lattice)
    throw Error(ErrorCode::kInput,
                "the server has replaced the model by one of another size or place: open it again");
  model_.emplace(std::move(event.summary), options_.memory_budget_bytes);
  instance_.forgetModel();
  queries_ = {};
}

void Engine::handle(ModelsListed) {
  throw Error(ErrorCode::kInternal, "an engine opens a model; it asked for no list");
}

void Engine::handle(BlobArrived event) {
  queries_.arrived(event.blob);
  if (options_.has_cache) arrivals_.push_back({event.blob, event.bytes});
  const bool was_root_page = event.use.kind == BlobKind::kRootPage;
  deliver(event.blob, event.use, std::move(event.bytes));
  if (!was_root_page || !link_.session()->givesFirstBlobs()) return;
  if (const auto coarsest = model_->firstWish())
    link_.session()->expectUnasked(coarsest->blob, coarsest->use);
}

void Engine::deliver(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes) {
  // What several rungs share is fetched once.
  for (const Wish& wish : instance_.wishes())
    if (wish.blob == blob && wish.use != use) model_->take(wish.blob, wish.use, bytes);
  model_->take(blob, use, std::move(bytes));
}

void Engine::finishCacheQuery(const BlobRef& blob, std::optional<std::vector<std::byte>> bytes) {
  const auto use = queries_.finish(blob, bytes.has_value());
  wishes_waiting_ = true;
  if (!use || !bytes) return;
  cache_bytes_ += bytes->size();
  deliver(blob, *use, std::move(*bytes));
}

bool Engine::exhausted() const noexcept {
  return options_.offline && queries_.idle() && !wishes_waiting_ && (!model_ || model_->decoding() == 0);
}

void Engine::handle(BlobRefused event) {
  model_->refuse(event.blob,
                 "the server cannot give blob " + std::to_string(event.blob.number) + ": " + event.message);
}

void Engine::handle(WishCancelled) { wishes_waiting_ = true; }

void Engine::handle(ServerLeaving event) {
  link_.end("the server is going away (" + event.reason + ")", now_);
}

void Engine::handle(ModelChanged) { link_.restart(now_); }

void Engine::finishDecode(DecodeResult result) {
  if (model_) model_->finishDecode(std::move(result));
}

void Engine::step(TimePoint now) {
  now_ = now;
  if (link_.session()) {
    try {
      link_.session()->tick(now);
    } catch (const Error& silent) {
      link_.fail(silent, now);
    }
  }
  if (!model_) return;
  const bool refined = instance_.refine(*model_);
  if (refined || std::exchange(wishes_waiting_, false)) renewWishes();
}

void Engine::renewWishes() {
  wishes_waiting_ = false;
  if (!link_.session() && !options_.has_cache) return;
  std::vector<Wish> wishes;
  uint64_t waiting_bytes = model_->undecodedBytes();
  /// @return false if no more may be asked for.
  const auto ask = [&](const Wish& wish) {
    if (!model_->wants(wish)) return true;
    waiting_bytes += wish.blob.bytes;
    if (waiting_bytes > kMaxUndecodedBytes && !wishes.empty()) return false;
    if (!options_.has_cache || queries_.lacks(wish)) wishes.push_back(wish);
    return wishes.size() < kMaxWishesAtOnce;
  };
  if (const auto first = model_->firstWish()) ask(*first);
  for (const Wish& wish : instance_.wishes())
    if (!ask(wish)) break;
  if (link_.session()) link_.session()->setWishes(wishes);
}

proto::Bytes Engine::takeOutgoing() {
  return link_.session() ? link_.session()->takeOutgoing() : proto::Bytes();
}

std::vector<DecodeJob> Engine::takeDecodeJobs() {
  return model_ ? model_->takeDecodeJobs() : std::vector<DecodeJob>();
}

const std::string& Engine::failure() const noexcept {
  static const std::string kNone;
  return model_ ? model_->failure() : kNone;
}

EngineCounts Engine::counts() const noexcept {
  EngineCounts counts;
  counts.received_bytes = link_.receivedBytes();
  counts.cache_bytes = cache_bytes_;
  if (link_.session()) counts.open_wishes = link_.session()->openWishes();
  if (!model_) return counts;
  counts.decoding = model_->decoding();
  counts.resident_bytes = model_->meshes().bytes();
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
