#include "common/mesh_images/png_writer.h"

#include <csetjmp>
#include <cstddef>
#include <exception>
#include <vector>

#include <png.h>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/io/atomic_file.h"

namespace lode {
namespace {

/// Handles an error of libpng by a jump to the last setjmp(). Unlike libpng's own handler, prints nothing.
[[noreturn]] void jumpInSilence(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void ignore(png_structp, png_const_charp) {}

/// Owns libpng's state for writing a file. The pointers are null if memory ran out.
struct PngHandle {
  PngHandle() = default;
  ~PngHandle() { png_destroy_write_struct(&writer, &info); }
  PngHandle(const PngHandle&) = delete;
  PngHandle& operator=(const PngHandle&) = delete;

  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, jumpInSilence, ignore);
  png_infop info = writer ? png_create_info_struct(writer) : nullptr;
};

/// Writes a PNG file row by row. libpng reports errors by a jump to the last setjmp(), so no function that
/// calls setjmp() has objects with destructors.
class PngWriter {
 public:
  PngWriter(const std::filesystem::path& path, glm::uvec2 size, bool has_alpha, OutputName name)
      : path_(path), file_(path, {}, name) {
    if (!png_.info || !begin(size, has_alpha)) fail();
  }

  /// @param row  one texel per column of the image. Omits their alpha if the file has no alpha.
  void write(std::span<const glm::u8vec4> row) {
    if (!tryToWrite(row.data())) fail();
  }
  void finish() {
    if (!tryToEnd()) fail();
    file_.commit();
  }

 private:
  [[noreturn]] void fail() const {
    if (failure_) std::rethrow_exception(failure_);
    throw Error(ErrorCode::kInternal, path_.string() + ": libpng cannot encode the image");
  }

  bool begin(glm::uvec2 size, bool has_alpha) {
    if (setjmp(png_jmpbuf(png_.writer)) != 0) return false;
    png_set_write_fn(png_.writer, this, append, nullptr);
    png_set_user_limits(png_.writer, kMaxTextureEdgePx, kMaxTextureEdgePx);
    png_set_IHDR(png_.writer, png_.info, size.x, size.y, 8,
                 has_alpha ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png_.writer, png_.info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png_.writer, png_.info);
    if (!has_alpha) png_set_filler(png_.writer, 0, PNG_FILLER_AFTER);
    return true;
  }
  bool tryToWrite(const glm::u8vec4* row) {
    if (setjmp(png_jmpbuf(png_.writer)) != 0) return false;
    png_write_row(png_.writer, reinterpret_cast<png_const_bytep>(row));
    return true;
  }
  bool tryToEnd() {
    if (setjmp(png_jmpbuf(png_.writer)) != 0) return false;
    png_write_end(png_.writer, nullptr);
    return true;
  }

  static void append(png_structp png, png_bytep data, png_size_t size) {
    auto* const self = static_cast<PngWriter*>(png_get_io_ptr(png));
    try {
      self->file_.write({reinterpret_cast<const std::byte*>(data), size});
      return;
    } catch (...) {
      self->failure_ = std::current_exception();
    }
    png_error(png, "");
  }

  const std::filesystem::path path_;
  AtomicFile file_;
  std::exception_ptr failure_;
  PngHandle png_;
};

}  // namespace

void writePng(const std::filesystem::path& path, glm::uvec2 size, bool has_alpha, const FillRow& fill,
              OutputName name) {
  PngWriter png(path, size, has_alpha, name);
  std::vector<glm::u8vec4> row(size.x);
  for (uint32_t y = 0; y < size.y; ++y) {
    fill(y, row);
    png.write(row);
  }
  png.finish();
}

}  // namespace lode
