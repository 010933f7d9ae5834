#include "common/image/jpeg_decoder.h"

#include <cstdio>

namespace lode {
namespace {

void stopEndlessScans(j_common_ptr info) {
  if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number <= kMaxJpegScans) return;
  auto& errors = *reinterpret_cast<JpegErrors*>(info->err);
  std::snprintf(errors.message, sizeof errors.message, "more than %d scans", kMaxJpegScans);
  std::longjmp(errors.jump, 1);
}

}  // namespace

JpegDecoder::JpegDecoder(std::span<const std::byte> file, bool refuse_warnings) : file_(file) {
  info_.err = errors_.install(refuse_warnings);
  progress_.progress_monitor = stopEndlessScans;
}

bool JpegDecoder::readHeader() {
  if (setjmp(errors_.jump) != 0) return false;
  jpeg_create_decompress(&info_);
  info_.progress = &progress_;
  jpeg_mem_src(&info_, reinterpret_cast<const unsigned char*>(file_.data()), file_.size());
  jpeg_read_header(&info_, TRUE);
  return true;
}

bool JpegDecoder::readTexels(std::span<glm::u8vec4> texels) {
  if (setjmp(errors_.jump) != 0) return false;
  info_.out_color_space = JCS_EXT_RGBA;
  jpeg_start_decompress(&info_);
  while (info_.output_scanline < info_.output_height) {
    auto* row =
        reinterpret_cast<JSAMPLE*>(texels.data() + size_t{info_.output_scanline} * info_.output_width);
    jpeg_read_scanlines(&info_, &row, 1);
  }
  jpeg_finish_decompress(&info_);
  return true;
}

}  // namespace lode
