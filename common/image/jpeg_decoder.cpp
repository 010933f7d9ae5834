#include "common/image/jpeg_decoder.h"

#include <cstdio>
#include <type_traits>

namespace lode {
namespace {

static_assert(std::is_standard_layout_v<JpegErrors>, "libjpeg's pointer to the manager is one to all of it");

JpegErrors& errorsOf(j_common_ptr codec) { return *reinterpret_cast<JpegErrors*>(codec->err); }

[[noreturn]] void jumpOut(j_common_ptr codec) {
  JpegErrors& errors = errorsOf(codec);
  errors.manager.format_message(codec, errors.message);
  std::longjmp(errors.jump, 1);
}

void noteWarning(j_common_ptr codec, int level) {
  JpegErrors& errors = errorsOf(codec);
  if (level >= 0) return;
  if (errors.refuse_warnings) jumpOut(codec);
  if (errors.warning[0] == 0) errors.manager.format_message(codec, errors.warning);
}

void stopEndlessScans(j_common_ptr info) {
  if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number <= kMaxJpegScans) return;
  JpegErrors& errors = errorsOf(info);
  std::snprintf(errors.message, sizeof errors.message, "more than %d scans", kMaxJpegScans);
  std::longjmp(errors.jump, 1);
}

}  // namespace

jpeg_error_mgr* JpegErrors::install(bool warnings_too) {
  refuse_warnings = warnings_too;
  jpeg_std_error(&manager);
  manager.error_exit = jumpOut;
  manager.emit_message = noteWarning;
  return &manager;
}

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

glm::uvec2 JpegDecoder::shrink() {
  if (setjmp(errors_.jump) != 0) return glm::uvec2(0);
  info_.scale_num = 1;
  info_.scale_denom = 8;
  jpeg_calc_output_dimensions(&info_);
  return {info_.output_width, info_.output_height};
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
