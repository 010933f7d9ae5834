#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client/render/gl_names.h"
#include "client/render/residency/block_allocator.h"

namespace lode::render {

/// A range of one page.
struct GpuBlock {
  uint32_t page = 0;
  uint32_t offset_bytes = 0;
  uint32_t bytes = 0;
};

/// The GPU memory of meshes: a few large buffers, made as they are needed and never more than the budget,
/// each sub-allocated. Used on the thread of its context.
class GpuPages {
 public:
  GpuPages(uint64_t budget_bytes, uint32_t page_bytes);

  /// Pages that there are stay while they hold something.
  void setBudget(uint64_t bytes) noexcept { budget_bytes_ = bytes; }
  /// @return nothing if no page has room and none can be added. bytes > 0.
  std::optional<GpuBlock> allocate(uint32_t bytes);
  void release(const GpuBlock& block);
  /// Frees the buffers of pages that hold nothing, but one.
  void dropEmptyPages();
  /// Frees everything, and makes room for blocks of these sizes, allocated in this order: in pages where they
  /// fit, else in one for all of them. @return false if the budget does not allow it; then nothing is freed.
  bool clearFor(const std::vector<uint64_t>& sizes);

  GLuint buffer(uint32_t page) const noexcept { return pages_[page] ? pages_[page]->buffer.get() : 0; }
  uint32_t pageCount() const noexcept { return static_cast<uint32_t>(pages_.size()); }
  uint64_t pageBytes(uint32_t page) const noexcept { return pages_[page] ? pages_[page]->bytes : 0; }
  uint64_t usedBytes() const noexcept { return used_bytes_; }
  uint64_t capacityBytes() const noexcept { return capacity_bytes_; }

 private:
  struct Page {
    GlBuffer buffer;
    uint32_t bytes;
    BlockAllocator allocator;
  };
  bool fitInPages(const std::vector<uint64_t>& sizes) const;
  uint32_t sizeOfNewPage(uint32_t needed_bytes, uint64_t capacity_bytes) const noexcept;
  bool addPage(uint32_t needed_bytes);

  uint64_t budget_bytes_;
  uint32_t page_bytes_;
  uint64_t used_bytes_ = 0, capacity_bytes_ = 0;
  uint64_t most_bytes_ = 0;                   ///< that pages have ever taken
  std::vector<std::unique_ptr<Page>> pages_;  ///< null: a page that was dropped
};

}  // namespace lode::render
