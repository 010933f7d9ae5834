#pragma once

#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

namespace lode {

/// How libjpeg reports errors: by a jump to `jump`, that its user has set before each call. Nothing with a
/// destructor may be made between setjmp() and the calls. For one (de)compressor, that it outlives.
struct JpegErrors {
  jpeg_error_mgr manager{};  // first: libjpeg knows no more of it
  std::jmp_buf jump{};
  bool refuse_warnings = false;
  char message[JMSG_LENGTH_MAX]{};  ///< of the error
  char warning[JMSG_LENGTH_MAX]{};  ///< the first, empty if there was none

  /// @param warnings_too  warnings are errors: of what is missing in a picture libjpeg makes grey.
  /// @return for a (de)compressor's `err`, before it is created.
  jpeg_error_mgr* install(bool warnings_too);
};

}  // namespace lode
