#include "client/render/residency/mesh_residency.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <iterator>
#include <unordered_set>
#include <utility>

#include "client/core/cache/mesh_cache.h"
#include "client/core/lod/cut.h"
#include "client/render/residency/gpu_vertex.h"

namespace lode::render {
namespace {

/// A newer cut aborts the current upload if its threshold is coarser by this factor. Such a cut has about
/// half the triangles.
constexpr double kOvertaking = 1.4;
constexpr uint32_t kPieceBytes = 256u << 10;  ///< bytes uploaded between two checks of the clock

/// Calls visit(mesh) for each part and fallback that has triangles.
template <typename Visit>
void forEachMesh(const core::ViewCuts& view_cuts, Visit visit) {
  for (size_t number = 0; number < partCount(*view_cuts.all); ++number) {
    const std::shared_ptr<const Mesh>& mesh = partOf(*view_cuts.all, number).mesh;
    if (mesh && !mesh->triangles.empty()) visit(mesh);
  }
}

/// Returns each mesh of the cuts once.
std::vector<std::shared_ptr<const Mesh>> meshesOf(const core::ViewCuts& view_cuts) {
  std::vector<std::shared_ptr<const Mesh>> meshes;
  std::unordered_set<const Mesh*> known;
  forEachMesh(view_cuts, [&](const std::shared_ptr<const Mesh>& mesh) {
    if (known.insert(mesh.get()).second) meshes.push_back(mesh);
  });
  return meshes;
}

/// Returns the GPU memory that cuts and their fallbacks take.
uint64_t bytesOf(const core::ViewCuts& view_cuts) {
  uint64_t bytes = 0;
  for (const auto& mesh : meshesOf(view_cuts)) bytes += core::drawnBytes(*mesh);
  return bytes;
}

static_assert(sizeof(glm::u32vec3) == core::kDrawnTriangleBytes);
static_assert(sizeof(LatticeBox) == core::kDrawnClusterBytes);

}  // namespace

/// Tracks how much of a frame's UploadBudget is left.
struct MeshResidency::Allowance {
  UploadBudget budget;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  uint64_t used_bytes = 0;

  uint32_t left() const {
    if (budget.wait) return kPieceBytes;
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
    if (spent.count() >= budget.ms || used_bytes >= budget.bytes) return 0;
    return static_cast<uint32_t>(std::min<uint64_t>(kPieceBytes, budget.bytes - used_bytes));
  }
};

MeshResidency::MeshResidency(const ResidencyOptions& options)
    : options_(options), pages_(options.budget_bytes, options.page_bytes), staging_(options.staging_bytes) {}

void MeshResidency::setBudget(uint64_t bytes) noexcept {
  if (bytes == options_.budget_bytes) return;
  if (bytes > options_.budget_bytes) rejected_.reset();
  options_.budget_bytes = bytes;
  pages_.setBudget(bytes);
}

void MeshResidency::release() {
  for (auto* const cuts : {&newest_, &target_, &before_, &rejected_, &complete_}) cuts->reset();
  exchange_.reset();
  instances_.clear();
  entries_.clear();
  pages_ = GpuPages(options_.budget_bytes, options_.page_bytes);
  drawn_serial_ = ++serial_;
  kept_from_ = std::max(kept_from_, drawn_serial_);
}

void MeshResidency::show(const std::shared_ptr<const core::Cut>& cut) {
  if (newest_ && newest_->all == cut) return;
  show(cut ? std::make_shared<const core::ViewCuts>(core::ViewCuts{{cut}, cut}) : nullptr);
}

const std::shared_ptr<const core::Cut>& MeshResidency::drawnCut(size_t instance) const noexcept {
  static const std::shared_ptr<const core::Cut> kNothing;
  return instance < instances_.size() ? instances_[instance].cut : kNothing;
}

std::span<const DrawItem> MeshResidency::drawn(size_t instance) const noexcept {
  if (instance >= instances_.size()) return {};
  return instances_[instance].drawn;
}

uint64_t MeshResidency::uploadInRenderThread(const UploadBudget& budget) {
  mixtures_.clear();
  Allowance allowance{budget};
  while (begin() && staging_.open(allowance.budget.wait)) {
    const bool is_done = advance(allowance);
    staging_.close();
    if (!is_done && !allowance.budget.wait) break;
  }
  if (target_ && steps_done_ > steps_drawn_) switchToResidentSteps();
  return allowance.used_bytes;
}

/// Returns true if a much coarser cut is waiting, for example because the camera has started to move. The cut
/// in progress is then obsolete.
bool MeshResidency::isOvertaken() const noexcept {
  return target_ && newest_ && newest_ != target_ && !has_room_alone_ &&
         thresholdRad(*newest_->all) >= kOvertaking * thresholdRad(*target_->all);
}

/// Starts the next upload if none is in progress. @return false if there is nothing to upload.
bool MeshResidency::begin() {
  if (isOvertaken()) {
    if (steps_done_ > steps_drawn_) switchToResidentSteps();
    if (target_) endExchange();
  }
  if (target_) return true;
  if (!newest_ || newest_ == complete_ || newest_ == rejected_) return false;
  rejected_.reset();
  if (bytesOf(*newest_) > options_.budget_bytes) {
    rejected_ = newest_;
    return false;
  }
  target_ = newest_;
  CutExchange::Cuts from;
  if (mayMix())
    for (const DrawnInstance& instance : instances_) from.push_back(instance.cut);
  startExchange(std::move(from));
  has_room_alone_ = false;
  target_serial_ = ++serial_;
  pinTarget();
  return true;
}

/// Returns true if the drawn cuts and the target have the same build and number of instances, so that they
/// can be mixed.
bool MeshResidency::mayMix() const noexcept {
  return !instances_.empty() && instances_.size() == target_->cuts.size() &&
         instances_.front().cut->build == target_->cuts.front()->build;
}

void MeshResidency::startExchange(CutExchange::Cuts from) {
  exchange_.emplace(std::move(from), target_->cuts);
  steps_done_ = steps_drawn_ = next_in_step_ = 0;
}

void MeshResidency::pinDrawn() noexcept {
  for (const DrawnInstance& instance : instances_)
    for (Entry* const entry : instance.entries) entry->used_by = drawn_serial_;
}

void MeshResidency::pinTarget() {
  forEachMesh(*target_, [&](const std::shared_ptr<const Mesh>& mesh) {
    const auto it = entries_.find(mesh);
    if (it != entries_.end()) it->second.used_by = target_serial_;
  });
}

bool MeshResidency::pinned(const Entry& entry) const noexcept {
  return entry.used_by == drawn_serial_ || (target_ && entry.used_by == target_serial_);
}

/// Uploads until the target is resident. If newer cuts are waiting, uploads only the next region.
/// @return false if the allowance ended first or the target was rejected.
bool MeshResidency::advance(Allowance& allowance) {
  const size_t steps = exchange_->steps().size();
  while (steps_done_ < steps) {
    if (!advanceStep(exchange_->steps()[steps_done_], allowance)) return false;
    ++steps_done_;
    next_in_step_ = 0;
    if (steps_done_ > 1 && newest_ != target_) break;
  }
  switchToResidentSteps();
  if (target_) endExchange();
  return true;
}

bool MeshResidency::advanceStep(const ExchangeStep& step, Allowance& allowance) {
  for (; next_in_step_ < step.parts.size(); ++next_in_step_) {
    const InstancePart& part_at = step.parts[next_in_step_];
    const core::CutPart& part = partOf(*target_->cuts[part_at.instance], part_at.number);
    if (!part.mesh || part.mesh->triangles.empty()) continue;
    const auto it = entries_.find(part.mesh);
    Entry* entry = it != entries_.end() ? &it->second : allocate(part.mesh);
    if (entry == nullptr) {
      makeRoom(allowance);
      return false;
    }
    if (!entry->complete && !uploadMesh(*part.mesh, *entry, allowance)) return false;
  }
  return true;
}

/// Makes room for the target. Draws the target's resident regions, so that the meshes of the older parts can
/// be evicted. If no further region is resident, evicts all other meshes. If there is still not enough room,
/// rejects the target.
void MeshResidency::makeRoom(Allowance& allowance) {
  if (steps_done_ > steps_drawn_) {
    switchToResidentSteps();
  } else if (!has_room_alone_ && makeRoomForTargetAlone()) {
    allowance.budget.wait = true;  // wait, because nothing can be drawn until the whole target is resident
  } else {
    reject();
  }
}

bool MeshResidency::uploadMesh(const Mesh& mesh, Entry& entry, Allowance& allowance) {
  while (!entry.complete) {
    const uint32_t limit = std::min(allowance.left(), staging_.freeBytes());
    const uint32_t bytes = uploadPiece(mesh, entry, limit);
    if (bytes == 0) return false;
    allowance.used_bytes += bytes;
    entry.complete = entry.triangles_done == mesh.triangles.size() &&
                     entry.clusters_done == clusterCount(mesh.triangles.size());
  }
  return true;
}

/// Uploads the next piece of a mesh. @return bytes uploaded; 0 if the limit is too small for one element.
uint32_t MeshResidency::uploadPiece(const Mesh& mesh, Entry& entry, uint32_t limit_bytes) {
  const GLuint buffer = pages_.buffer(entry.block.page);
  const auto vertices = static_cast<uint32_t>(mesh.positions.size());
  const uint32_t vertex_bytes = vertexBytes(mesh.attributes);
  if (entry.vertices_done < vertices) {
    const uint32_t count = std::min(limit_bytes / vertex_bytes, vertices - entry.vertices_done);
    if (count == 0) return 0;
    const auto bytes = count * vertex_bytes;
    const std::span<std::byte> room = staging_.take(bytes);
    packVertices(mesh, entry.vertices_done, room);
    staging_.copyTo(buffer, entry.block.offset_bytes + uint64_t{entry.vertices_done} * vertex_bytes);
    for (uint32_t i = 0; i < count; ++i) {
      entry.box.add(unpackPosition(mesh.positions[entry.vertices_done + i]));
    }
    entry.vertices_done += count;
    return bytes;
  }
  const uint64_t triangles_at = entry.block.offset_bytes + uint64_t{vertices} * vertex_bytes;
  if (entry.triangles_done < mesh.triangles.size())
    return uploadNext(std::span(mesh.triangles), entry.triangles_done, limit_bytes, buffer, triangles_at);
  std::vector<LatticeBox>& boxes = entry.clusters->boxes;
  if (boxes.empty()) boxes.assign(clusterCount(mesh.triangles.size()), entry.box);
  const uint64_t boxes_at = triangles_at + mesh.triangles.size() * core::kDrawnTriangleBytes;
  return uploadNext(std::span<const LatticeBox>(boxes), entry.clusters_done, limit_bytes, buffer, boxes_at);
}

/// Uploads the next elements of an array, which begins at offset `at` of the buffer. @return bytes uploaded;
/// 0 if the limit is too small for one element.
template <typename Element>
uint32_t MeshResidency::uploadNext(std::span<const Element> elements, uint32_t& done, uint32_t limit_bytes,
                                   GLuint buffer, uint64_t at) {
  const auto left = static_cast<uint32_t>(elements.size()) - done;
  const uint32_t count = std::min(limit_bytes / static_cast<uint32_t>(sizeof(Element)), left);
  if (count == 0) return 0;
  const std::span<std::byte> room = staging_.take(count * sizeof(Element));
  std::memcpy(room.data(), elements.data() + done, room.size());
  staging_.copyTo(buffer, at + uint64_t{done} * sizeof(Element));
  done += count;
  return static_cast<uint32_t>(room.size());
}

/// Allocates a block for a mesh and evicts unpinned meshes as needed. @return null if there is no room.
MeshResidency::Entry* MeshResidency::allocate(const std::shared_ptr<const Mesh>& mesh) {
  const uint64_t bytes = core::drawnBytes(*mesh);
  if (bytes > options_.budget_bytes || bytes > (1u << 31)) return nullptr;
  std::optional<GpuBlock> block;
  while (!(block = pages_.allocate(static_cast<uint32_t>(bytes)))) {
    if (!evictOldest()) return nullptr;
  }
  Entry entry;
  entry.block = *block;
  entry.clusters = std::make_shared<MeshClusters>(MeshClusters{mesh->cluster_boxes, {}});
  entry.used_by = target_serial_;
  return &entries_.emplace(mesh, entry).first->second;
}

bool MeshResidency::evictOldest() {
  auto oldest = entries_.end();
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    if (pinned(it->second)) continue;
    if (oldest == entries_.end() || it->second.used_by < oldest->second.used_by) oldest = it;
  }
  if (oldest == entries_.end()) return false;
  if (oldest->second.used_by >= kept_from_) kept_from_ = oldest->second.used_by + 1;
  pages_.release(oldest->second.block);
  entries_.erase(oldest);
  pages_.dropEmptyPages();
  return true;
}

/// Evicts all meshes, even drawn meshes, so that the target can replace them within the same frame. Allocates
/// the target's largest meshes first, which leaves the fewest gaps.
bool MeshResidency::makeRoomForTargetAlone() {
  std::vector<std::shared_ptr<const Mesh>> meshes = meshesOf(*target_);
  const auto bytesOf = [](const std::shared_ptr<const Mesh>& mesh) { return core::drawnBytes(*mesh); };
  std::ranges::stable_sort(meshes, std::greater(), bytesOf);
  std::vector<uint64_t> sizes;
  std::ranges::transform(meshes, std::back_inserter(sizes), bytesOf);
  if (!pages_.clearFor(sizes)) return false;
  instances_.clear();
  complete_.reset();
  drawn_serial_ = 0;
  kept_from_ = std::max(kept_from_, target_serial_);
  entries_.clear();
  for (const std::shared_ptr<const Mesh>& mesh : meshes) allocate(mesh);
  startExchange({});
  has_room_alone_ = true;
  return true;
}

void MeshResidency::reject() {
  rejected_ = target_;
  endExchange();
}

/// Ends the upload of the target. The drawn meshes stay.
void MeshResidency::endExchange() {
  if (steps_drawn_ > 0) before_ = target_;
  target_.reset();
  exchange_.reset();
  pinDrawn();
  trimTo(options_.spare_bytes);
}

/// Sets the drawn cuts: the target if it is resident, otherwise mixtures of the target and the cuts that were
/// drawn before.
void MeshResidency::switchToResidentSteps() {
  CutExchange::Cuts cuts = exchange_->after(steps_done_);
  steps_drawn_ = steps_done_;
  instances_.resize(cuts.size());
  for (size_t i = 0; i < cuts.size(); ++i) {
    if (cuts[i] == instances_[i].cut) continue;
    if (cuts[i] != target_->cuts[i]) mixtures_.push_back(cuts[i]);
    setDrawnCut(instances_[i], std::move(cuts[i]));
  }
  drawn_serial_ = ++serial_;
  complete_ = nullptr;
  if (steps_done_ == exchange_->steps().size()) {
    complete_ = target_;
    return endExchange();
  }
  pinDrawn();
  target_serial_ = ++serial_;
  pinTarget();
  trimTo(options_.spare_bytes);
}

void MeshResidency::setDrawnCut(DrawnInstance& instance, std::shared_ptr<const core::Cut> cut) {
  instance.cut = std::move(cut);
  instance.drawn.clear();
  instance.entries.clear();
  const auto asAngle = [focal_px = core::focalPx(instance.cut->view)](float px) {
    return static_cast<float>(px / focal_px);
  };
  for (size_t number = 0; number < partCount(*instance.cut); ++number) {
    const core::CutPart& part = partOf(*instance.cut, number);
    DrawItem& item = instance.drawn.emplace_back();
    const auto it = entries_.find(part.mesh);
    if (it == entries_.end()) continue;  // the part has no triangles
    Entry& entry = it->second;
    instance.entries.push_back(&entry);
    const uint32_t vertex_bytes = vertexBytes(part.mesh->attributes);
    const uint32_t base = entry.block.offset_bytes / vertex_bytes;
    const auto vertices = static_cast<uint32_t>(part.mesh->positions.size());
    const auto indices = static_cast<uint32_t>(part.mesh->triangles.size() * 3);
    const uint32_t first_index = (base + vertices) * (vertex_bytes / 4);
    item = {entry.block.page,
            base,
            first_index,
            indices,
            first_index + indices,
            entry.box,
            entry.clusters,
            part.mesh->attributes,
            part.node,
            part.lod,
            asAngle(part.error_px),
            part.error_model,
            asAngle(std::min(part.threshold_px, instance.cut->threshold_px)),
            asAngle(part.threshold_px)};
  }
}

void MeshResidency::keepFrom(uint64_t serial) {
  const uint64_t before = std::exchange(kept_from_, serial);
  if (serial > before) trimTo(options_.spare_bytes);
}

/// Evicts spare meshes, oldest first, until they take at most spare_bytes. A mesh is spare unless it is
/// drawn, kept or part of the target.
void MeshResidency::trimTo(uint64_t spare_bytes) {
  struct Spare {
    uint64_t age = 0;
    Entries::iterator entry;
  };
  constexpr uint64_t kExpired = 0;
  std::vector<Spare> spare;
  uint64_t bytes = 0;
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    if (pinned(it->second) || it->second.used_by >= kept_from_) continue;
    bytes += it->second.block.bytes;
    // Expired meshes can never be drawn again, so evict them first. Check each mesh only once, because
    // another thread may release a mesh at any time.
    spare.push_back({it->first.expired() ? kExpired : it->second.used_by, it});
  }
  std::stable_sort(spare.begin(), spare.end(), [](const Spare& a, const Spare& b) { return a.age < b.age; });
  for (const auto& [age, it] : spare) {
    if (bytes <= spare_bytes && age != kExpired) break;
    bytes -= it->second.block.bytes;
    pages_.release(it->second.block);
    entries_.erase(it);
  }
  pages_.dropEmptyPages();
}

}  // namespace lode::render
