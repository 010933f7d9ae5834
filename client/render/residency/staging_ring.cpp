#include "client/render/residency/staging_ring.h"

#include <cassert>

#include "common/error.h"

namespace lode::render {

StagingRing::StagingRing(uint32_t segment_bytes)
    : segment_bytes_(segment_bytes), buffer_(GlBuffer::create()) {
  const GLbitfield access = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  const auto bytes = static_cast<GLsizeiptr>(uint64_t{segment_bytes} * kSegments);
  glNamedBufferStorage(buffer_.get(), bytes, nullptr, access);
  mapped_ = static_cast<std::byte*>(glMapNamedBufferRange(buffer_.get(), 0, bytes, access));
  if (mapped_ == nullptr) {
    throw Error(ErrorCode::kIo, "the graphics driver has no memory left for uploads; close other programs");
  }
}

StagingRing::~StagingRing() {
  for (GLsync fence : fences_) glDeleteSync(fence);
}

bool StagingRing::open(bool wait) {
  GLsync& fence = fences_[segment_];
  if (fence != nullptr) {
    constexpr GLuint64 kForeverNs = 10'000'000'000;
    const GLenum state = glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, wait ? kForeverNs : 0);
    if (state == GL_TIMEOUT_EXPIRED) return false;
    glDeleteSync(fence);
    fence = nullptr;
  }
  used_bytes_ = last_bytes_ = 0;
  return true;
}

std::span<std::byte> StagingRing::take(uint32_t bytes) {
  assert(bytes <= freeBytes());
  std::byte* room = mapped_ + uint64_t{segment_} * segment_bytes_ + used_bytes_;
  used_bytes_ += bytes;
  last_bytes_ = bytes;
  return {room, bytes};
}

void StagingRing::copyTo(GLuint buffer, uint64_t offset_bytes) const {
  const uint64_t from = uint64_t{segment_} * segment_bytes_ + used_bytes_ - last_bytes_;
  glCopyNamedBufferSubData(buffer_.get(), buffer, static_cast<GLintptr>(from),
                           static_cast<GLintptr>(offset_bytes), last_bytes_);
}

void StagingRing::copyTo(GLuint texture_array, GLint layer, glm::ivec2 corner, glm::ivec2 size) const {
  const uint64_t from = uint64_t{segment_} * segment_bytes_ + used_bytes_ - last_bytes_;
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer_.get());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
  glTextureSubImage3D(texture_array, 0, corner.x, corner.y, layer, size.x, size.y, 1, GL_RGBA,
                      GL_UNSIGNED_BYTE, reinterpret_cast<const void*>(from));
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
}

void StagingRing::close() {
  if (used_bytes_ == 0) return;
  fences_[segment_] = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  segment_ = (segment_ + 1) % kSegments;
}

}  // namespace lode::render
