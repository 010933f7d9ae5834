#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "client/render/gl_names.h"

namespace lode::render {

/// Memory that stays mapped and through which bytes go to buffers of the GPU: three segments, one a frame, so
/// that the CPU writes one while the GPU still reads the others. Used on the thread of its context.
class StagingRing {
 public:
  /// @throws Error kIo if the driver has no memory for it.
  explicit StagingRing(uint32_t segment_bytes);
  ~StagingRing();
  StagingRing(const StagingRing&) = delete;
  StagingRing& operator=(const StagingRing&) = delete;

  /// Begins a segment. @return false if the GPU still reads it and `wait` is false.
  bool open(bool wait);
  uint32_t freeBytes() const noexcept { return segment_bytes_ - used_bytes_; }
  /// Room to write to, `bytes` <= freeBytes(); then copy it with copyTo().
  std::span<std::byte> take(uint32_t bytes);
  /// Has the GPU copy what was written to the last take().
  void copyTo(GLuint buffer, uint64_t offset_bytes) const;
  /// The same into a rectangle of one layer of a texture: RGBA texels by rows, as many as were taken.
  void copyTo(GLuint texture_array, GLint layer, glm::ivec2 corner, glm::ivec2 size) const;
  /// Ends the segment begun by open(); it is not written to again before the GPU has read it.
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
