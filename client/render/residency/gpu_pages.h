#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "client/render/gl/gl_names.h"

namespace lode::render {

/// Allocates ranges of a buffer by best fit; among equal fits, the smallest offset wins. release() joins
/// neighbouring free ranges. Uses no OpenGL. Not thread safe.
class BlockAllocator {
 public:
  /// Alignment of offsets and lengths: a common multiple of the two vertex sizes, 16 and 24 bytes.
  static constexpr uint32_t kAlignment = 48;

  /// @param capacity_bytes  size of the buffer; rounded down to the alignment.
  explicit BlockAllocator(uint32_t capacity_bytes);

  /// @param bytes  size, > 0. @return the offset in bytes, or nothing if no free range is long enough.
  std::optional<uint32_t> allocate(uint32_t bytes);
  /// @param offset  offset that allocate() returned.
  /// @param bytes   size that was passed to allocate().
  void release(uint32_t offset, uint32_t bytes);

  uint32_t usedBytes() const noexcept { return used_bytes_; }
  bool empty() const noexcept { return used_bytes_ == 0; }
  static constexpr uint32_t roundUp(uint32_t bytes) noexcept {
    return (bytes + kAlignment - 1) / kAlignment * kAlignment;
  }

 private:
  std::map<uint32_t, uint32_t> free_;  ///< sizes of the free ranges, by offset
  uint32_t used_bytes_ = 0;
};

/// A range of a page.
struct GpuBlock {
  uint32_t page = 0;
  uint32_t offset_bytes = 0;
  uint32_t bytes = 0;
};

/// GPU memory for meshes: a few large buffers (pages) that are divided into blocks. Pages are created on
/// demand within a budget. Use the object on the thread of its OpenGL context.
class GpuPages {
 public:
  GpuPages(uint64_t budget_bytes, uint32_t page_bytes);

  /// Changes the budget. Pages above the budget stay until they are empty.
  void setBudget(uint64_t bytes) noexcept { budget_bytes_ = bytes; }
  /// Allocates a block. @param bytes  size, > 0. @return nothing if no page has room and no page can be
  /// added.
  std::optional<GpuBlock> allocate(uint32_t bytes);
  void release(const GpuBlock& block);
  /// Frees empty pages except one.
  void dropEmptyPages();
  /// Frees everything and makes room for blocks of these sizes, which the caller then allocates in this
  /// order. Uses ordinary pages if the blocks fit into them, else one page for all blocks.
  /// @return false, without freeing anything, if the budget is too small.
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
  uint64_t most_bytes_ = 0;                   ///< peak of capacity_bytes_
  std::vector<std::unique_ptr<Page>> pages_;  ///< pages; null for a freed page
};

}  // namespace lode::render
