#pragma once

#include <cstddef>
#include <span>

#include <glm/glm.hpp>

#include "common/image/jpeg_errors.h"

namespace lode {

/// Scans that a JPEG may have: each costs a pass over the whole picture, however short it is. Progressive
/// files of the usual programs have about ten.
constexpr int kMaxJpegScans = 64;

/// A JPEG file from an untrusted source. It is read in two steps, so that its size can be judged in between:
/// libjpeg takes memory in proportion to it. To be used by one thread at a time.
class JpegDecoder {
 public:
  /// @param file  outlives the decoder.
  /// @param refuse_warnings  what libjpeg can mend is damage all the same.
  JpegDecoder(std::span<const std::byte> file, bool refuse_warnings);
  ~JpegDecoder() { jpeg_destroy_decompress(&info_); }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  /// @return false if the file is damaged: failure() says how.
  bool readHeader();
  /// Of a file whose header was read.
  glm::uvec2 size() const noexcept { return {info_.image_width, info_.image_height}; }
  /// Of a file whose header was read: colours of four inks, of which readTexels() makes nothing.
  bool isCmyk() const noexcept {
    return info_.jpeg_color_space == JCS_CMYK || info_.jpeg_color_space == JCS_YCCK;
  }
  /// Of a file whose header was read: whether readTexels() takes two bytes a texel and channel, for the
  /// coefficients of the whole picture.
  bool hasSeveralScans() noexcept { return jpeg_has_multiple_scans(&info_) != FALSE; }
  /// After readHeader(), once. @param texels  room for all of size(), by rows; alpha becomes 255.
  /// @return false if the file is damaged: failure() says how.
  bool readTexels(std::span<glm::u8vec4> texels);

  const char* failure() const noexcept { return errors_.message; }
  /// The first warning; empty if there was none.
  const char* warning() const noexcept { return errors_.warning; }

 private:
  const std::span<const std::byte> file_;
  jpeg_decompress_struct info_{};
  jpeg_progress_mgr progress_{};
  JpegErrors errors_;
};

}  // namespace lode
