#include "client/core/model.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "common/error.h"

namespace lode::core {
namespace {

uint64_t textureShare(const ModelSummary& summary, uint64_t budget_bytes) {
  return summary.textures ? budget_bytes / kTextureBudgetShare : 0;
}

uint64_t transitShare(uint64_t budget_bytes) {
  return std::min(budget_bytes / kTransitBudgetShare, kMaxTransitBytes);
}

/// Estimates the memory of a decode job: the result, and the same amount for the decoder.
uint64_t decodingBytes(const DecodeJob& job) {
  if (job.use.kind == BlobKind::kTile) return uint64_t{8} * job.image_size.x * job.image_size.y;
  return 2 * meshBytes(job.expected.vertices, job.expected.triangles, job.expected.attributes);
}

}  // namespace

Model::Model(ModelSummary summary, uint64_t memory_budget_bytes)
    : summary_(std::move(summary)), hierarchy_(summary_.nodes), meshes_(0) {
  if (summary_.textures) textures_.emplace(summary_.textures, 0);
  setMemoryBudget(memory_budget_bytes);
}

void Model::setMemoryBudget(uint64_t bytes) {
  memory_budget_bytes_ = bytes;
  hierarchy_budget_bytes_ = bytes / kHierarchyBudgetShare;
  transit_budget_bytes_ = transitShare(bytes);
  meshes_.setBudget(bytes - hierarchy_budget_bytes_ - 2 * transit_budget_bytes_ -
                    textureShare(summary_, bytes));
  if (textures_) textures_->setBudget(textureShare(summary_, bytes));
  ++version_;
}

uint64_t Model::build() const noexcept {
  uint64_t first = 0;
  std::memcpy(&first, summary_.build_id.bytes.data(), sizeof first);
  return first;
}

MeshKey Model::coarsest() const {
  const KnownNode& root = *hierarchy_.root();
  return {kRootKey, root.coarsestLod().value_or(static_cast<uint32_t>(root.lods.size()) - 1)};
}

std::optional<Request> Model::firstRequest() const {
  constexpr float kFirst = std::numeric_limits<float>::max();
  Request request{
      summary_.root_page, {BlobKind::kRootPage, {kRootKey, 0}}, proto::RequestClass::kVisible, kFirst};
  if (const Node* root = hierarchy_.root()) {
    const BlobRef& payload = root->lods[coarsest().lod].payload;
    if (!payload || meshes_.contains(coarsest())) return std::nullopt;
    request.blob = payload;
    request.use = {BlobKind::kMesh, coarsest()};
  }
  if (!wants(request)) return std::nullopt;
  return request;
}

bool Model::wants(const Request& request) const {
  return !lost_.contains(request.blob.number) && !postponed_.contains(request.blob.number) &&
         !decoding_.contains(toDecoding(request.blob, request.use));
}

void Model::take(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes) {
  ++version_;
  postponed_.arrived(blob.number);
  switch (use.kind) {
    case BlobKind::kPage:
    case BlobKind::kRootPage:
      return addPage(use, bytes);
    case BlobKind::kTextureSet:
      texture_blob_bytes_ += bytes.size();
      return textures_->takeSet(bytes);
    case BlobKind::kTile:
      texture_blob_bytes_ += bytes.size();
      return startDecode(blob, use, std::move(bytes));
    case BlobKind::kMesh:
      if (!meshes_.contains(use.mesh)) startDecode(blob, use, std::move(bytes));
      return;
  }
}

/// Adds a page to the hierarchy. Ignores a page that is already loaded, and a page whose parent page has been
/// evicted.
void Model::addPage(const BlobUse& use, std::span<const std::byte> bytes) {
  const KnownNode* owner = hierarchy_.find(use.mesh.node);
  const bool is_root_page = use.kind == BlobKind::kRootPage;
  if (is_root_page ? owner != nullptr : owner == nullptr || owner->childrenKnown()) return;
  HierarchyPage page = decodePage(bytes, use.mesh.node, is_root_page);
  if (is_root_page) {
    requireRoomFor(page.nodes.front().lods.back());
    hierarchy_.addRootPage(std::move(page));
  } else {
    hierarchy_.addPage(use.mesh.node, std::move(page));
  }
}

/// Checks that there is memory for the root's coarsest LOD, which is decoded even if it exceeds the budget.
/// Relies on the sizes that the server announces.
void Model::requireRoomFor(const Lod& first) const {
  const uint64_t needed_bytes =
      first.payload.bytes + 2 * meshBytes(first.vertices, first.triangles, summary_.attributes);
  if (needed_bytes <= memory_budget_bytes_ + kMaxFirstLodExcessBytes) return;
  throw Error(ErrorCode::kLimit, "the coarsest LOD of the model takes " + std::to_string(needed_bytes) +
                                     " bytes, and the memory budget is " +
                                     std::to_string(memory_budget_bytes_) + ": raise the memory budget");
}

void Model::startDecode(const BlobRef& blob, const BlobUse& use, std::vector<std::byte> bytes) {
  const KnownNode* node = hierarchy_.find(use.mesh.node);
  if (use.kind == BlobKind::kMesh && node == nullptr) return;  // the page of the node was evicted
  if (undecoded_bytes_ > transit_budget_bytes_) return;        // it may be requested again
  if (!decoding_.try_emplace(toDecoding(blob, use), Work{blob}).second) return;
  undecoded_bytes_ += blob.bytes;
  DecodeJob job;
  job.blob = blob;
  job.use = use;
  job.bytes = std::move(bytes);
  job.step = summary_.lattice.step;
  if (use.kind == BlobKind::kTile) {
    job.image_size = textures_->imageSize(blob.number);
    job.with_tail = textures_->isCoarsest(blob.number);
  } else {
    const Lod& lod = node->lods[use.mesh.lod];
    job.expected = {lod.triangles, lod.vertices, summary_.attributes, node->box};
    if (textures_) job.textures = textures_->set();
  }
  jobs_.push_back(std::move(job));
}

std::vector<DecodeJob> Model::takeDecodeJobs() {
  std::vector<DecodeJob> taken;
  while (!jobs_.empty()) {
    DecodeJob& job = jobs_.front();
    const uint64_t bytes = core::decodingBytes(job);
    if (decoding_bytes_ != 0 && decoding_bytes_ + bytes > transit_budget_bytes_) break;
    decoding_.at(toDecoding(job.blob, job.use)).bytes = bytes;
    decoding_bytes_ += bytes;
    taken.push_back(std::move(job));
    jobs_.pop_front();
  }
  return taken;
}

void Model::finishDecode(DecodeResult result) {
  const auto found = decoding_.find(toDecoding(result.blob, result.use));
  if (found == decoding_.end() || found->second.blob != result.blob) return;
  undecoded_bytes_ -= found->second.blob.bytes;
  decoding_bytes_ -= found->second.bytes;
  decoding_.erase(found);
  ++version_;
  if (result.image) return textures_->insert(result.blob.number, std::move(result.image));
  if (!result.decoded) {
    const std::string what = result.use.kind == BlobKind::kTile
                                 ? "blob " + std::to_string(result.blob.number)
                                 : "node " + std::to_string(result.use.mesh.node.value) + " lod " +
                                       std::to_string(result.use.mesh.lod);
    return lose(result.blob,
                what + " cannot be decoded: " + result.failure + ": run lodestreamd verify on the store");
  }
  insert(std::move(result));
}

/// Inserts a decoded mesh for every LOD of its node that has the same payload.
void Model::insert(DecodeResult result) {
  const KnownNode* node = hierarchy_.find(result.use.mesh.node);
  if (node == nullptr) return;  // the page of the node was evicted
  const Lod& decoded = node->lods[result.use.mesh.lod];
  for (uint32_t lod = 0; lod < node->lods.size(); ++lod) {
    const Lod& same = node->lods[lod];
    if (same.payload != decoded.payload || same.triangles != decoded.triangles ||
        same.vertices != decoded.vertices)
      continue;
    const MeshKey key{node->key, lod};
    meshes_.insert(key, result.decoded, result.footprint);
    if (key == coarsest()) meshes_.pin(key);
  }
}

void Model::lose(const BlobRef& blob, const std::string& why) {
  ++version_;
  if (lost_.size() >= kMaxRefusedBlobs) lost_.clear();
  lost_.insert(blob.number);
  hierarchy_.lose(blob.number);
  if (textures_) textures_->lose(blob.number);
  if (failure_.empty()) failure_ = why;
}

void Model::postpone(const BlobRef& blob, const std::string& why, TimePoint now) {
  ++version_;
  postponed_.add(blob.number, why, now);
}

}  // namespace lode::core
