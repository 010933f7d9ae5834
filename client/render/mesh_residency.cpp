#include "client/render/mesh_residency.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <iterator>
#include <utility>

#include "client/core/drawn_bytes.h"
#include "client/core/shown_parts.h"
#include "client/render/gpu_vertex.h"

namespace lode::render {
namespace {

constexpr uint32_t kPieceBytes = 256u << 10;  ///< between two looks at the clock

/// That a cut takes of the GPU, with its fallbacks.
uint64_t bytesOf(const core::Cut& cut) {
  uint64_t bytes = 0;
  for (size_t number = 0; number < partCount(cut); ++number)
    if (partOf(cut, number).mesh) bytes += core::drawnBytes(*partOf(cut, number).mesh);
  return bytes;
}

}  // namespace

/// What is left of a frame's UploadBudget.
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

uint64_t MeshResidency::uploadInRenderThread(const UploadBudget& budget) {
  if (!target_ && !begin()) return 0;
  Allowance allowance{budget};
  if (!staging_.open(budget.wait)) return 0;
  bool complete = advance(allowance);
  staging_.close();
  while (!complete && target_ && allowance.budget.wait) {
    staging_.open(true);
    complete = advance(allowance);
    staging_.close();
  }
  if (target_ && steps_done_ > steps_drawn_) drawWhatIsThere();
  return allowance.used_bytes;
}

/// @return false if there is nothing to do.
bool MeshResidency::begin() {
  if (!newest_ || newest_ == drawn_cut_ || newest_ == rejected_) return false;
  rejected_.reset();
  if (bytesOf(*newest_) > options_.budget_bytes) {
    rejected_ = newest_;
    return false;
  }
  target_ = newest_;
  const bool by_region = newest_exchange_ == Exchange::kByRegion && drawn_cut_ && !is_mixed_ &&
                         drawn_cut_->build == target_->build;
  startExchange(by_region ? drawn_cut_ : nullptr);
  has_room_alone_ = false;
  target_serial_ = ++serial_;
  pin(*target_, target_serial_);
  return true;
}

void MeshResidency::startExchange(std::shared_ptr<const core::Cut> from) {
  exchange_.emplace(std::move(from), target_);
  steps_done_ = steps_drawn_ = next_in_step_ = 0;
}

void MeshResidency::pin(const core::Cut& cut, uint64_t serial) {
  for (size_t number = 0; number < partCount(cut); ++number) {
    const auto it = entries_.find(partOf(cut, number).mesh);
    if (it != entries_.end()) it->second.used_by = serial;
  }
}

bool MeshResidency::pinned(const Entry& entry) const noexcept {
  return entry.used_by == drawn_serial_ || (target_ && entry.used_by == target_serial_);
}

/// @return true if all of the target is on the GPU; false if the allowance ended first or the target was
/// rejected.
bool MeshResidency::advance(Allowance& allowance) {
  while (steps_done_ < exchange_->steps().size()) {
    if (!advanceStep(exchange_->steps()[steps_done_], allowance)) return false;
    ++steps_done_;
    next_in_step_ = 0;
  }
  return true;
}

bool MeshResidency::advanceStep(const ExchangeStep& step, Allowance& allowance) {
  for (; next_in_step_ < step.numbers.size(); ++next_in_step_) {
    const core::CutPart& part = partOf(*target_, step.numbers[next_in_step_]);
    if (!part.mesh || part.mesh->triangles.empty()) continue;
    const auto it = entries_.find(part.mesh);
    Entry* entry = it != entries_.end() ? &it->second : place(part.mesh);
    if (entry == nullptr) {
      makeRoom(allowance);
      return false;
    }
    if (!entry->complete && !uploadMesh(*part.mesh, *entry, allowance)) return false;
  }
  return true;
}

/// What has lost its place to regions of the target goes first, then all that is drawn.
void MeshResidency::makeRoom(Allowance& allowance) {
  if (steps_done_ > steps_drawn_) {
    drawWhatIsThere();
  } else if (!has_room_alone_ && makeRoomForTargetAlone()) {
    allowance.budget.wait = true;  // nothing is drawn until the whole target is there
  } else {
    reject();
  }
}

bool MeshResidency::uploadMesh(const Mesh& mesh, Entry& entry, Allowance& allowance) {
  while (entry.triangles_done < mesh.triangles.size()) {
    const uint32_t limit = std::min(allowance.left(), staging_.freeBytes());
    const uint32_t bytes = uploadPiece(mesh, entry, limit);
    if (bytes == 0) return false;
    allowance.used_bytes += bytes;
  }
  entry.complete = true;
  return true;
}

/// @return bytes uploaded; 0 if the limit does not allow one element.
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
  constexpr uint32_t kTriangleBytes = sizeof(glm::u32vec3);
  static_assert(kTriangleBytes == core::kDrawnTriangleBytes);
  const auto triangles = static_cast<uint32_t>(mesh.triangles.size());
  const uint32_t count = std::min(limit_bytes / kTriangleBytes, triangles - entry.triangles_done);
  if (count == 0) return 0;
  const std::span<std::byte> room = staging_.take(count * kTriangleBytes);
  std::memcpy(room.data(), mesh.triangles.data() + entry.triangles_done, room.size());
  staging_.copyTo(buffer, entry.block.offset_bytes + uint64_t{vertices} * vertex_bytes +
                              uint64_t{entry.triangles_done} * kTriangleBytes);
  entry.triangles_done += count;
  return count * kTriangleBytes;
}

/// @return null if there is no room, although all that is not drawn or wanted was evicted.
MeshResidency::Entry* MeshResidency::place(const std::shared_ptr<const Mesh>& mesh) {
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

/// Gives up what is drawn now, so that the target can take its place within the same frame: its largest
/// meshes first, which leaves the fewest gaps.
bool MeshResidency::makeRoomForTargetAlone() {
  std::vector<std::shared_ptr<const Mesh>> meshes;
  for (size_t number = 0; number < partCount(*target_); ++number) {
    const core::CutPart& part = partOf(*target_, number);
    if (part.mesh && !part.mesh->triangles.empty()) meshes.push_back(part.mesh);
  }
  const auto bytesOf = [](const std::shared_ptr<const Mesh>& mesh) { return core::drawnBytes(*mesh); };
  std::ranges::stable_sort(meshes, std::greater(), bytesOf);
  std::vector<uint64_t> sizes;
  std::ranges::transform(meshes, std::back_inserter(sizes), bytesOf);
  if (!pages_.clearFor(sizes)) return false;
  drawn_.clear();
  drawn_cut_.reset();
  drawn_serial_ = 0;
  kept_from_ = std::max(kept_from_, target_serial_);
  entries_.clear();
  for (const std::shared_ptr<const Mesh>& mesh : meshes)
    if (!entries_.contains(mesh)) place(mesh);
  startExchange(nullptr);
  has_room_alone_ = true;
  return true;
}

void MeshResidency::reject() {
  rejected_ = std::move(target_);
  target_.reset();
  exchange_.reset();
  if (drawn_cut_) pin(*drawn_cut_, drawn_serial_);
  trimTo(options_.spare_bytes);
}

/// The target, or, until all of it is there, its mixture with what was drawn before.
void MeshResidency::drawWhatIsThere() {
  drawn_cut_ = exchange_->after(steps_done_);
  steps_drawn_ = steps_done_;
  is_mixed_ = drawn_cut_ != target_ && steps_done_ > 1;
  drawn_serial_ = ++serial_;
  pin(*drawn_cut_, drawn_serial_);
  if (drawn_cut_ == target_) {
    target_.reset();
    exchange_.reset();
  } else {
    target_serial_ = ++serial_;
    pin(*target_, target_serial_);
  }
  listDrawn();
  trimTo(options_.spare_bytes);
}

void MeshResidency::listDrawn() {
  drawn_.clear();
  for (size_t number = 0; number < partCount(*drawn_cut_); ++number) {
    const core::CutPart& part = partOf(*drawn_cut_, number);
    DrawItem& item = drawn_.emplace_back();
    const auto it = entries_.find(part.mesh);
    if (it == entries_.end()) continue;  // it has no triangles
    const Entry& entry = it->second;
    if (entry.clusters->boxes.empty()) entry.clusters->boxes = {entry.box};
    entry.clusters->hidden.resize(entry.clusters->boxes.size());
    const uint32_t vertex_bytes = vertexBytes(part.mesh->attributes);
    const uint32_t base = entry.block.offset_bytes / vertex_bytes;
    const auto vertices = static_cast<uint32_t>(part.mesh->positions.size());
    item = {entry.block.page,
            base,
            (base + vertices) * (vertex_bytes / 4),
            static_cast<uint32_t>(part.mesh->triangles.size() * 3),
            entry.box,
            entry.clusters,
            part.mesh->attributes,
            part.node,
            part.rung,
            part.error_px,
            part.error_model};
  }
}

void MeshResidency::keepFrom(uint64_t serial) {
  const uint64_t before = std::exchange(kept_from_, serial);
  if (serial > before) trimTo(options_.spare_bytes);
}

/// Evicts, oldest first, until meshes that are neither drawn, kept nor wanted take at most spare_bytes.
void MeshResidency::trimTo(uint64_t spare_bytes) {
  struct Spare {
    uint64_t age = 0;
    Entries::iterator entry;
  };
  constexpr uint64_t kNeverAgain = 0;
  std::vector<Spare> spare;
  uint64_t bytes = 0;
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    if (pinned(it->second) || it->second.used_by >= kept_from_) continue;
    bytes += it->second.block.bytes;
    // Meshes that nobody holds any more can never be asked for again: they go first. Looked at once, since
    // another thread may let go of one at any time.
    spare.push_back({it->first.expired() ? kNeverAgain : it->second.used_by, it});
  }
  std::stable_sort(spare.begin(), spare.end(), [](const Spare& a, const Spare& b) { return a.age < b.age; });
  for (const auto& [age, it] : spare) {
    if (bytes <= spare_bytes && age != kNeverAgain) break;
    bytes -= it->second.block.bytes;
    pages_.release(it->second.block);
    entries_.erase(it);
  }
  pages_.dropEmptyPages();
}

}  // namespace lode::render
