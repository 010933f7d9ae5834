#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "client/render/gl/gl_names.h"

namespace lode::render {

/// Permanently mapped memory for uploads: a ring of three segments, one per frame. The CPU writes one segment
/// while the GPU still reads the others. Use the object on the thread of its OpenGL context.
class StagingRing {
 public:
  /// @throws Error kIo if the driver is out of memory.
  explicit StagingRing(uint32_t segment_bytes);
  ~StagingRing();
  StagingRing(const StagingRing&) = delete;
  StagingRing& operator=(const StagingRing&) = delete;

  /// Begins a segment. @return false if the GPU still reads the segment and `wait` is false.
  bool open(bool wait);
  uint32_t freeBytes() const noexcept { return segment_bytes_ - used_bytes_; }
  /// Allocates a range of the segment for the caller to write. Call copyTo() after writing.
  /// @param bytes  size, <= freeBytes().
  std::span<std::byte> take(uint32_t bytes);
  /// Copies the range of the last take() into a buffer, on the GPU.
  void copyTo(GLuint buffer, uint64_t offset_bytes) const;
  /// Copies the range of the last take(), which has RGBA texels row by row, into a rectangle of a texture
  /// layer.
  void copyTo(GLuint texture_array, GLint layer, glm::ivec2 corner, glm::ivec2 size) const;
  /// Ends the segment that open() began. The ring reuses a segment only after the GPU has read it.
  void close();

  static constexpr uint32_t kSegments = 3;

 private:
  uint32_t segment_bytes_;
  uint32_t segment_ = 0, used_bytes_ = 0, last_bytes_ = 0;
  GlBuffer buffer_;
  std::byte* mapped_ = nullptr;
  std::array<GLsync, kSegments> fences_{};
};

}  // namespace lode::render
