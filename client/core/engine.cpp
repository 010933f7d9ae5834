#include "client/core/engine.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "common/error.h"

namespace lode::core {

Engine::Engine(EngineOptions options)
    : options_(std::move(options)),
      link_(options_.session, options_.jitter_seed),
      instance_(options_.triangle_budget) {}

void Engine::connect(TimePoint now) {
  link_.begin(model_ && model_->hierarchy().root() ? model_->summary().build_id : BlobName{}, now);
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
  if (model_ && (model_->summary().lattice != event.summary.lattice))
    throw Error(ErrorCode::kInput,
                "the server has replaced the model by one of another size or place: open it again");
  model_.emplace(std::move(event.summary), options_.memory_budget_bytes);
  instance_.forgetModel();
}

void Engine::handle(ModelsListed) {
  throw Error(ErrorCode::kInternal, "an engine opens a model; it asked for no list");
}

void Engine::handle(BlobArrived event) {
  // What several rungs share is fetched once.
  for (const Wish& wish : instance_.wishes())
    if (wish.blob == event.blob && wish.use != event.use) model_->take(wish.blob, wish.use, event.bytes);
  const bool was_root_page = event.use.kind == BlobKind::kRootPage;
  model_->take(event.blob, event.use, std::move(event.bytes));
  if (!was_root_page) return;
  const Rung& coarsest = model_->hierarchy().root()->rungs.back();
  const auto rung = static_cast<uint32_t>(model_->hierarchy().root()->rungs.size()) - 1;
  if (coarsest.payload) link_.session()->expectUnasked(coarsest.payload, {BlobKind::kMesh, {kRootKey, rung}});
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
  Session* const session = link_.session();
  if (!session) return;
  std::vector<Wish> wishes;
  if (const auto first = model_->firstWish()) wishes.push_back(*first);
  uint64_t waiting_bytes = model_->undecodedBytes();
  for (const Wish& wish : instance_.wishes()) {
    if (!model_->wants(wish)) continue;
    waiting_bytes += wish.blob.bytes;
    if (waiting_bytes > kMaxUndecodedBytes && !wishes.empty()) break;
    if (wishes.size() >= kMaxWishesAtOnce) break;
    wishes.push_back(wish);
  }
  session->setWishes(wishes);
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
  if (link_.session()) counts.open_wishes = link_.session()->openWishes();
  if (!model_) return counts;
  counts.decoding = model_->decoding();
  counts.resident_bytes = model_->meshes().bytes();
  counts.known_nodes = model_->hierarchy().size();
  counts.texture_blob_bytes = model_->textureBlobBytes();
  if (const TextureStream* textures = model_->textures()) {
    counts.texture_bytes = textures->residentBytes();
    counts.tiles = textures->residentCount();
    counts.tiles_left_out = textures->leftOut();
  }
  return counts;
}

}  // namespace lode::core
