#include "client/render/residency/gpu_pages.h"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace lode::render {
namespace {

constexpr uint64_t kMostPageBytes = 1u << 31;
/// A new page has room for kMeshesOfPage meshes as large as its first mesh, so that less than 1/8 of the page
/// remains unused at its end. For this purpose, a page grows to at most kMostBytesForThem, because drivers
/// need long to create larger buffers.
constexpr uint64_t kMeshesOfPage = 8, kMostBytesForThem = 32u << 20;

}  // namespace

BlockAllocator::BlockAllocator(uint32_t capacity_bytes) {
  const uint32_t capacity = capacity_bytes / kAlignment * kAlignment;
  if (capacity > 0) free_.emplace(0, capacity);
}

std::optional<uint32_t> BlockAllocator::allocate(uint32_t bytes) {
  const uint32_t wanted = roundUp(bytes);
  auto best = free_.end();
  for (auto it = free_.begin(); it != free_.end(); ++it) {
    if (it->second >= wanted && (best == free_.end() || it->second < best->second)) best = it;
  }
  if (best == free_.end()) return std::nullopt;
  const auto [offset, length] = *best;
  free_.erase(best);
  if (length > wanted) free_.emplace(offset + wanted, length - wanted);
  used_bytes_ += wanted;
  return offset;
}

void BlockAllocator::release(uint32_t offset, uint32_t bytes) {
  uint32_t length = roundUp(bytes);
  assert(used_bytes_ >= length);
  used_bytes_ -= length;
  auto next = free_.lower_bound(offset);
  if (next != free_.end() && offset + length == next->first) {
    length += next->second;
    next = free_.erase(next);
  }
  if (next != free_.begin()) {
    const auto before = std::prev(next);
    assert(before->first + before->second <= offset);
    if (before->first + before->second == offset) {
      before->second += length;
      return;
    }
  }
  free_.emplace(offset, length);
}

GpuPages::GpuPages(uint64_t budget_bytes, uint32_t page_bytes)
    : budget_bytes_(budget_bytes), page_bytes_(page_bytes) {}

/// Returns the size of a new page. Returns 0 if the budget does not allow a page of needed_bytes.
uint32_t GpuPages::sizeOfNewPage(uint32_t needed_bytes, uint64_t capacity_bytes) const noexcept {
  const uint64_t left = budget_bytes_ - std::min(budget_bytes_, capacity_bytes);
  const uint64_t needed = BlockAllocator::roundUp(needed_bytes);
  const uint64_t roomy = std::min(kMeshesOfPage * needed, kMostBytesForThem);
  const uint64_t size = std::min(left, std::max({uint64_t{page_bytes_}, roomy, needed}));
  return size >= needed ? static_cast<uint32_t>(size) : 0;
}

bool GpuPages::addPage(uint32_t needed_bytes) {
  const uint32_t bytes = sizeOfNewPage(needed_bytes, capacity_bytes_);
  if (bytes == 0) return false;
  while (glGetError() != GL_NO_ERROR) {
  }
  GlBuffer buffer = GlBuffer::create();
  glNamedBufferStorage(buffer.get(), bytes, nullptr, 0);
  if (glGetError() != GL_NO_ERROR) {
    // The driver is out of memory. From now on, do not allocate more than the peak so far.
    budget_bytes_ = most_bytes_;
    return false;
  }
  auto page = std::make_unique<Page>(Page{std::move(buffer), bytes, BlockAllocator(bytes)});
  const auto hole = std::find(pages_.begin(), pages_.end(), nullptr);
  if (hole != pages_.end()) {
    *hole = std::move(page);
  } else {
    pages_.push_back(std::move(page));
  }
  capacity_bytes_ += bytes;
  most_bytes_ = std::max(most_bytes_, capacity_bytes_);
  return true;
}

std::optional<GpuBlock> GpuPages::allocate(uint32_t bytes) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    for (uint32_t i = 0; i < pages_.size(); ++i) {
      if (!pages_[i]) continue;
      if (const auto offset = pages_[i]->allocator.allocate(bytes)) {
        used_bytes_ += BlockAllocator::roundUp(bytes);
        return GpuBlock{i, *offset, bytes};
      }
    }
    if (attempt == 0 && !addPage(bytes)) break;
  }
  return std::nullopt;
}

void GpuPages::release(const GpuBlock& block) {
  pages_[block.page]->allocator.release(block.offset_bytes, block.bytes);
  used_bytes_ -= BlockAllocator::roundUp(block.bytes);
}

void GpuPages::dropEmptyPages() {
  bool kept_one = false;
  for (auto& page : pages_) {
    if (!page || !page->allocator.empty()) continue;
    if (!kept_one) {
      kept_one = true;
      continue;
    }
    capacity_bytes_ -= page->bytes;
    page.reset();
  }
}

bool GpuPages::clearFor(const std::vector<uint64_t>& sizes) {
  uint64_t together = 0;
  for (const uint64_t bytes : sizes) together += bytes + BlockAllocator::kAlignment;
  const bool fit_in_pages = fitInPages(sizes);
  if (!fit_in_pages && (together > budget_bytes_ || together > kMostPageBytes)) return false;
  pages_.clear();
  used_bytes_ = capacity_bytes_ = 0;
  if (!fit_in_pages) addPage(static_cast<uint32_t>(together));
  return true;
}

bool GpuPages::fitInPages(const std::vector<uint64_t>& sizes) const {
  std::vector<BlockAllocator> pages;
  uint64_t capacity = 0;
  for (const uint64_t bytes : sizes) {
    if (bytes > kMostPageBytes) return false;
    const auto needed = static_cast<uint32_t>(bytes);
    const bool placed = std::any_of(pages.begin(), pages.end(),
                                    [&](BlockAllocator& page) { return page.allocate(needed).has_value(); });
    if (placed) continue;
    const uint32_t added = sizeOfNewPage(needed, capacity);
    if (added == 0) return false;
    capacity += added;
    pages.emplace_back(added);
    if (!pages.back().allocate(needed)) return false;
  }
  return true;
}

}  // namespace lode::render
