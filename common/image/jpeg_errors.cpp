#include "common/image/jpeg_errors.h"

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

}  // namespace

jpeg_error_mgr* JpegErrors::install(bool warnings_too) {
  refuse_warnings = warnings_too;
  jpeg_std_error(&manager);
  manager.error_exit = jumpOut;
  manager.emit_message = noteWarning;
  return &manager;
}

}  // namespace lode
