#include "client/core/engine.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "common/error.h"

namespace lode::core {
namespace {

constexpr uint64_t kMaxUndecodedBytes = 64ull << 20;  // encoded payloads waiting to be decoded

}  // namespace

DecodeResult runDecodeJob(const DecodeJob& job) {
  try {
    return {job.mesh, std::make_shared<const Mesh>(decodePayload(job.bytes, job.step, job.expected)), {}};
  } catch (const std::exception& error) {
    return {job.mesh, nullptr, error.what()};
  }
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
  purposes_[summary_->root_page.number] = {{kRootKey, 0}, true, true};
}

void Engine::handle(ModelsListed) {
  throw Error(ErrorCode::kInternal, "an engine opens a model; it asked for no list");
}

void Engine::handle(BlobArrived event) {
  const auto found = purposes_.find(event.blob.number);
  if (found == purposes_.end()) return;
  const Purpose purpose = found->second;
  purposes_.erase(found);
  if (purpose.is_page) {
    addPage(purpose, event.bytes);
  } else {
    startDecode(purpose.mesh, std::move(event.bytes));
  }
  changed_ = true;
}

void Engine::handle(BlobRefused event) {
  purposes_.erase(event.blob.number);
  refused_.insert(event.blob.number);
  fail("the server cannot give blob " + std::to_string(event.blob.number) + ": " + event.message);
  changed_ = true;
}

void Engine::handle(ServerLeaving event) {
  throw Error(ErrorCode::kNetwork, "the server is going away (" + event.reason + "): connect again");
}

void Engine::handle(ModelChanged) {
  throw Error(ErrorCode::kNetwork, "the server has replaced the model: open it again");
}

void Engine::addPage(const Purpose& purpose, std::span<const std::byte> bytes) {
  HierarchyPage page = decodePage(bytes, purpose.mesh.node, purpose.is_root_page);
  if (!purpose.is_root_page) return hierarchy_->addPage(purpose.mesh.node, std::move(page));
  hierarchy_->addRootPage(std::move(page));
  const Node& root = *hierarchy_->root();
  const BlobRef& coarsest = root.rungs.back().payload;
  if (!coarsest) return;
  session_.expectUnasked(coarsest);
  purposes_[coarsest.number] = {{kRootKey, static_cast<uint32_t>(root.rungs.size()) - 1}, false, false};
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
                   {rung.triangles, rung.vertices, summary_->attributes, node.box}});
}

void Engine::finishDecode(DecodeResult result) {
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
  cache_.insert(result.mesh, std::move(result.decoded));
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
  if (!changed_ || !view_ || !hierarchy_ || !hierarchy_->root()) return;
  changed_ = false;
  Refinement refinement =
      refine(*hierarchy_, cache_, summary_->lattice, summary_->attributes, *view_, refine_options_);
  cache_.use(refinement.in_use, refinement.ancestors);
  if (refinement.cut) cut_ = std::move(refinement.cut);
  limited_ = refinement.limited;
  settled_ = refinement.settled;
  wanted_ = std::move(refinement.wanted);
  renewWishes();
}

void Engine::renewWishes() {
  std::vector<BlobWish> wishes;
  uint64_t waiting_bytes = undecoded_bytes_;
  for (const Wanted& wanted : wanted_) {
    if (refused_.contains(wanted.blob.number) || (!wanted.is_page && decoding_.contains(wanted.mesh)))
      continue;
    waiting_bytes += wanted.blob.bytes;
    if (waiting_bytes > kMaxUndecodedBytes && !wishes.empty()) break;
    if (wishes.size() >= kMaxWishesAtOnce) break;
    wishes.push_back({wanted.blob, wanted.wish_class, wanted.priority_px});
    purposes_.try_emplace(wanted.blob.number, Purpose{wanted.mesh, wanted.is_page, false});
  }
  session_.setWishes(wishes);
}

uint64_t Engine::cutBlobBytes() const {
  uint64_t bytes = 0;
  if (!cut_ || !hierarchy_) return 0;
  for (const CutPart& part : cut_->parts)
    if (const Node* node = hierarchy_->find(part.node)) bytes += node->rungs[part.rung].payload.bytes;
  return bytes;
}

EngineCounts Engine::counts() const noexcept {
  return {session_.receivedBytes(), session_.openWishes(), decoding_.size(), cache_.bytes(),
          hierarchy_ ? hierarchy_->size() : 0};
}

}  // namespace lode::core
