#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <span>

#include <glm/glm.hpp>
#include <jpeglib.h>

namespace lode {

/// Error handler of one libjpeg codec. The handler must outlive the codec. An error jumps to `jump`. Set
/// `jump` with setjmp() before each call of libjpeg, and create no object with a destructor between setjmp()
/// and the call.
struct JpegErrors {
  jpeg_error_mgr manager{};  // must be the first member, because libjpeg receives a pointer to this member
  std::jmp_buf jump{};
  bool refuse_warnings = false;
  char message[JMSG_LENGTH_MAX]{};  ///< text of the error
  char warning[JMSG_LENGTH_MAX]{};  ///< text of the first warning, or empty

  /// @param warnings_too  if true, warnings are errors: libjpeg only warns of missing parts and fills them
  /// with grey.
  /// @return the value for the codec's field `err`; assign it before you create the codec.
  jpeg_error_mgr* install(bool warnings_too);
};

/// Largest accepted number of scans in a JPEG file. Even a short scan costs a pass over the whole image.
/// Common progressive files have about ten scans.
constexpr int kMaxJpegScans = 64;

/// Decodes a JPEG file from an untrusted source in two steps, header and texels. Between the steps the caller
/// can check the size, because libjpeg allocates memory in proportion to the size. Not thread safe.
class JpegDecoder {
 public:
  /// @param file  contents of the file; must outlive the decoder.
  /// @param refuse_warnings  if true, refuses damage that libjpeg could repair.
  JpegDecoder(std::span<const std::byte> file, bool refuse_warnings);
  ~JpegDecoder() { jpeg_destroy_decompress(&info_); }
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  /// @return false if the file is damaged; failure() says how.
  bool readHeader();
  // Call the functions below after readHeader().
  glm::uvec2 size() const noexcept { return {info_.image_width, info_.image_height}; }
  /// Returns true for CMYK colours, which readTexels() does not convert.
  bool isCmyk() const noexcept {
    return info_.jpeg_color_space == JCS_CMYK || info_.jpeg_color_space == JCS_YCCK;
  }
  /// Returns true if readTexels() needs two additional bytes per texel and channel, for the coefficients of
  /// the whole image.
  bool hasSeveralScans() noexcept { return jpeg_has_multiple_scans(&info_) != FALSE; }
  /// Makes readTexels() decode the image at 1/8 of its width and height, from the mean of each block.
  /// @return the size of the small image; 0 if the file is damaged; failure() says how.
  glm::uvec2 shrink();
  /// Decodes the image; call once. @param texels  rows of size(), or of the size that shrink() returned;
  /// alpha becomes 255.
  /// @return false if the file is damaged; failure() says how.
  bool readTexels(std::span<glm::u8vec4> texels);

  const char* failure() const noexcept { return errors_.message; }
  /// Returns the first warning, or an empty text.
  const char* warning() const noexcept { return errors_.warning; }

 private:
  const std::span<const std::byte> file_;
  jpeg_decompress_struct info_{};
  jpeg_progress_mgr progress_{};
  JpegErrors errors_;
};

}  // namespace lode
