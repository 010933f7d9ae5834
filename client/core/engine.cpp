#include "client/core/engine.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "client/core/tile_tail.h"
#include "common/error.h"

namespace lode::core {
namespace {

constexpr uint64_t kMaxUndecodedBytes = 64ull << 20;  // encoded payloads waiting to be decoded

}  // namespace

DecodeResult runDecodeJob(const DecodeJob& job) {
  DecodeResult result;
  result.mesh = job.mesh;
  result.tile = job.tile;
  try {
    if (job.tile) {
      TileImage image = decodeTile(job.bytes, job.tile->image_size);
      if (job.tile->with_tail) makeTail(image);
      result.image = std::make_shared<const TileImage>(std::move(image));
      return result;
    }
    auto mesh = std::make_shared<const Mesh>(decodePayload(job.bytes, job.step, job.expected));
    if (job.textures)
      result.footprint =
          std::make_shared<const TextureFootprint>(makeFootprint(*mesh, *job.textures, job.step));
    result.decoded = std::move(mesh);
  } catch (const std::exception& error) {
    result.failure = error.what();
  }
  return result;
}

Engine::Engine(EngineOptions options, TimePoint now)
    : options_(std::move(options)), session_(options_.session, now), cache_(options_.memory_budget_bytes) {
  refine_options_.triangle_budget = options_.triangle_budget;
  // Half for the wanted cut, half for the one still shown, so that neither waits for the other.
  refine_options_.cut_budget_bytes = options_.memory_budget_bytes / 2;
}

void Engine::receive(std::span<const std::byte> bytes, TimePoint now) {
  session_.receive(bytes, now);
  while (std::optional<SessionEvent> event = session_.nextEvent())
    std::visit([this](auto taken) { handle(std::move(taken)); }, std::move(*event));
}

void Engine::handle(ModelOpened event) {
  summary_ = std::move(event.summary);
  hierarchy_.emplace(summary_->nodes);
  purposes_[summary_->root_page.number] = {Kind::kRootPage, {kRootKey, 0}};
  if (!summary_->textures) return;
  const uint64_t texture_bytes = options_.memory_budget_bytes / kTextureBudgetShare;
  textures_.emplace(summary_->textures, texture_bytes);
  cache_ = MeshCache(options_.memory_budget_bytes - texture_bytes);
  refine_options_.cut_budget_bytes = cache_.budgetBytes() / 2;
}

void Engine::handle(ModelsListed) {
  throw Error(ErrorCode::kInternal, "an engine opens a model; it asked for no list");
}

void Engine::handle(BlobArrived event) {
  const auto found = purposes_.find(event.blob.number);
  if (found == purposes_.end()) return;
  const Purpose purpose = found->second;
  purposes_.erase(found);
  changed_ = true;
  switch (purpose.kind) {
    case Kind::kMesh:
      return startDecode(purpose.mesh, std::move(event.bytes));
    case Kind::kPage:
    case Kind::kRootPage:
      return addPage(purpose, event.bytes);
    case Kind::kTextureSet:
      texture_blob_bytes_ += event.bytes.size();
      return textures_->takeSet(event.bytes);
    case Kind::kTile:
      texture_blob_bytes_ += event.bytes.size();
      return startDecode(event.blob, std::move(event.bytes));
  }
}

void Engine::handle(BlobRefused event) {
  purposes_.erase(event.blob.number);
  refused_.insert(event.blob.number);
  fail("the server cannot give blob " + std::to_string(event.blob.number) + ": " + event.message);
  changed_ = true;
}

void Engine::handle(WishCancelled) { wishes_waiting_ = true; }

void Engine::handle(ServerLeaving event) {
  throw Error(ErrorCode::kNetwork, "the server is going away (" + event.reason + "): connect again");
}

void Engine::handle(ModelChanged) {
  throw Error(ErrorCode::kNetwork, "the server has replaced the model: open it again");
}

void Engine::addPage(const Purpose& purpose, std::span<const std::byte> bytes) {
  const bool is_root_page = purpose.kind == Kind::kRootPage;
  HierarchyPage page = decodePage(bytes, purpose.mesh.node, is_root_page);
  if (!is_root_page) return hierarchy_->addPage(purpose.mesh.node, std::move(page));
  hierarchy_->addRootPage(std::move(page));
  const Node& root = *hierarchy_->root();
  const BlobRef& coarsest = root.rungs.back().payload;
  if (!coarsest) return;
  session_.expectUnasked(coarsest);
  purposes_[coarsest.number] = {Kind::kMesh, {kRootKey, static_cast<uint32_t>(root.rungs.size()) - 1}};
}

void Engine::startDecode(MeshKey mesh, std::vector<std::byte> bytes) {
  if (decoding_.contains(mesh) || cache_.contains(mesh)) return;
  const Node& node = *hierarchy_->find(mesh.node);
  const Rung& rung = node.rungs[mesh.rung];
  undecoded_bytes_ += bytes.size();
  decoding_[mesh] = bytes.size();
  jobs_.push_back({mesh,
                   std::move(bytes),
                   summary_->lattice.step,
                   {rung.triangles, rung.vertices, summary_->attributes, node.box},
                   textures_ ? textures_->set() : nullptr,
                   std::nullopt});
}

void Engine::startDecode(const BlobRef& tile, std::vector<std::byte> bytes) {
  if (!decoding_tiles_.try_emplace(tile.number, bytes.size()).second) return;
  undecoded_bytes_ += bytes.size();
  DecodeJob job;
  job.bytes = std::move(bytes);
  job.tile = {tile.number, textures_->imageSize(tile.number), textures_->isCoarsest(tile.number)};
  jobs_.push_back(std::move(job));
}

void Engine::finishTile(DecodeResult result) {
  const auto found = decoding_tiles_.find(result.tile->blob);
  if (found == decoding_tiles_.end()) return;
  undecoded_bytes_ -= found->second;
  decoding_tiles_.erase(found);
  changed_ = true;
  if (result.image) return textures_->insert(result.tile->blob, std::move(result.image));
  refused_.insert(result.tile->blob);
  fail("blob " + std::to_string(result.tile->blob) + " cannot be decoded: " + result.failure);
}

void Engine::finishDecode(DecodeResult result) {
  if (result.tile) return finishTile(std::move(result));
  const auto found = decoding_.find(result.mesh);
  if (found == decoding_.end()) return;
  undecoded_bytes_ -= found->second;
  decoding_.erase(found);
  changed_ = true;
  if (!result.decoded) {
    const Node& node = *hierarchy_->find(result.mesh.node);
    refused_.insert(node.rungs[result.mesh.rung].payload.number);
    fail("node " + std::to_string(result.mesh.node.value) + " rung " + std::to_string(result.mesh.rung) +
         " cannot be decoded: " + result.failure + ": run lodestreamd verify on the store");
    return;
  }
  cache_.insert(result.mesh, std::move(result.decoded), std::move(result.footprint));
  const Node& root = *hierarchy_->root();
  if (result.mesh == MeshKey{kRootKey, static_cast<uint32_t>(root.rungs.size()) - 1}) cache_.pin(result.mesh);
}

void Engine::fail(std::string message) {
  if (failure_.empty()) failure_ = std::move(message);
}

void Engine::setView(const View& view, float threshold_px) {
  if (view_ == view && refine_options_.threshold_px == threshold_px) return;
  view_ = view;
  refine_options_.threshold_px = threshold_px;
  changed_ = true;
}

void Engine::step(TimePoint now) {
  session_.tick(now);
  if (std::exchange(wishes_waiting_, false) && !changed_) renewWishes();
  if (!changed_ || !view_ || !hierarchy_ || !hierarchy_->root()) return;
  changed_ = false;
  Refinement refinement =
      refine(*hierarchy_, cache_, summary_->lattice, summary_->attributes, *view_, refine_options_);
  cache_.use(refinement.in_use, refinement.ancestors);
  settled_ = refinement.settled;
  limited_ = refinement.limited;
  if (refinement.cut) {
    if (textures_) dressCut(*refinement.cut);
    cut_ = std::move(refinement.cut);
  }
  collectAsks(refinement.wanted);
  renewWishes();
}

/// Says which tiles the cut needs, and gives it those that are there.
void Engine::dressCut(Cut& cut) {
  const std::shared_ptr<const TextureSet>& set = textures_->set();
  std::vector<TexturedPart> parts;
  for (const CutPart& part : cut.parts) {
    if (!set) break;
    const MeshKey key{part.node, part.rung};
    if (cache_.footprint(key) == nullptr)  // decoded before the set was there
      cache_.setFootprint(key, std::make_shared<const TextureFootprint>(
                                   makeFootprint(*part.mesh, *set, summary_->lattice.step)));
    const ModelBox box = toModelBox(hierarchy_->find(part.node)->box, summary_->lattice.step);
    parts.push_back({cache_.footprint(key), distanceToBox(view_->eye_model, box), part.visible});
  }
  textures_->refine(parts, *view_, refine_options_.threshold_px);
  cut.textures = set;
  cut.tiles = textures_->residentTiles();
  settled_ = settled_ && textures_->complete();
  cut.converged = cut.converged && textures_->complete();
}

void Engine::collectAsks(const std::vector<Wanted>& wanted) {
  asks_.clear();
  for (const Wanted& want : wanted)
    asks_.push_back({{want.blob, want.wish_class, want.priority_px},
                     {want.is_page ? Kind::kPage : Kind::kMesh, want.mesh}});
  if (!textures_) return;
  if (!textures_->set()) {
    constexpr float kFirst = std::numeric_limits<float>::max();
    asks_.push_back({{textures_->setBlob(), proto::WishClass::kVisible, kFirst}, {Kind::kTextureSet, {}}});
  }
  for (const TextureStream::Missing& tile : textures_->missing())
    asks_.push_back(
        {{tile.blob, tile.visible ? proto::WishClass::kVisible : proto::WishClass::kMargin, tile.priority_px},
         {Kind::kTile, {}}});
  std::stable_sort(asks_.begin(), asks_.end(), [](const Ask& a, const Ask& b) {
    if (a.wish.wish_class != b.wish.wish_class) return a.wish.wish_class < b.wish.wish_class;
    return a.wish.priority_px > b.wish.priority_px;
  });
}

void Engine::renewWishes() {
  std::vector<BlobWish> wishes;
  uint64_t waiting_bytes = undecoded_bytes_;
  for (const auto& [wish, purpose] : asks_) {
    if (refused_.contains(wish.blob.number)) continue;
    if (purpose.kind == Kind::kMesh && decoding_.contains(purpose.mesh)) continue;
    if (purpose.kind == Kind::kTile && decoding_tiles_.contains(wish.blob.number)) continue;
    waiting_bytes += wish.blob.bytes;
    if (waiting_bytes > kMaxUndecodedBytes && !wishes.empty()) break;
    if (wishes.size() >= kMaxWishesAtOnce) break;
    wishes.push_back(wish);
    purposes_.try_emplace(wish.blob.number, purpose);
  }
  session_.setWishes(wishes);
}

uint64_t Engine::cutBlobBytes() const {
  uint64_t bytes = 0;
  if (!cut_ || !hierarchy_) return 0;
  for (const CutPart& part : cut_->parts)
    if (const Node* node = hierarchy_->find(part.node)) bytes += node->rungs[part.rung].payload.bytes;
  if (textures_) bytes += textures_->blobBytesInUse();
  return bytes;
}

EngineCounts Engine::counts() const noexcept {
  EngineCounts counts;
  counts.received_bytes = session_.receivedBytes();
  counts.open_wishes = session_.openWishes();
  counts.decoding = decoding_.size() + decoding_tiles_.size();
  counts.resident_bytes = cache_.bytes();
  counts.known_nodes = hierarchy_ ? hierarchy_->size() : 0;
  counts.texture_blob_bytes = texture_blob_bytes_;
  if (textures_) {
    counts.texture_bytes = textures_->residentBytes();
    counts.tiles = textures_->residentCount();
    counts.tiles_left_out = textures_->leftOut();
  }
  return counts;
}

}  // namespace lode::core
