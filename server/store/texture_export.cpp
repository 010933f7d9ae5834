#include "server/store/texture_export.h"

#include <algorithm>
#include <csetjmp>
#include <exception>
#include <set>
#include <string>

#include <png.h>

#include "common/atomic_file.h"
#include "common/error.h"
#include "common/tile_image.h"

namespace lode::store {
namespace {

/// What libpng holds for a file that it writes; null if there was no memory.
struct PngHandle {
  PngHandle() = default;
  ~PngHandle() { png_destroy_write_struct(&writer, &info); }
  PngHandle(const PngHandle&) = delete;
  PngHandle& operator=(const PngHandle&) = delete;

  png_structp writer = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = writer ? png_create_info_struct(writer) : nullptr;
};

/// Writes a PNG file row by row. libpng reports errors by a jump; no call but its own lies between that and
/// where it lands.
class PngWriter {
 public:
  PngWriter(const std::filesystem::path& path, glm::uvec2 size, bool has_alpha) : path_(path), file_(path) {
    if (!png_.info || !begin(size, has_alpha)) fail();
  }

  /// @param row  of the image's width; without alpha that channel is left out.
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

void exportImage(const Reader& reader, const Texture& texture, const std::filesystem::path& path) {
  const auto tileAt = [&](uint32_t x, uint32_t y) {
    return reader.readBlob(texture.tiles[tileIndex(texture, 0, x, y)].number);
  };
  const bool has_alpha = tileKind(tileAt(0, 0)) == TileKind::kWebp;
  PngWriter png(path, {texture.width, texture.height}, has_alpha);
  std::vector<TileImage> tiles(tilesAcross(texture, 0));
  std::vector<glm::u8vec4> row(texture.width);
  for (uint32_t y = 0; y < tilesDown(texture, 0); ++y) {
    for (uint32_t x = 0; x < tiles.size(); ++x)
      tiles[x] = decodeTile(tileAt(x, y), tileInnerSize(texture, 0, x, y) + 2 * kTileGutterPx);
    for (uint32_t line = 0; line < tileInnerSize(texture, 0, 0, y).y; ++line) {
      auto to = row.begin();
      for (const TileImage& tile : tiles) {
        const auto* const from = tile.texels.data() + size_t{line + kTileGutterPx} * tile.size.x;
        to = std::copy(from + kTileGutterPx, from + tile.size.x - kTileGutterPx, to);
      }
      png.write(row);
    }
  }
  png.finish();
}

/// The last part of a name, without its ending, in characters that every file system takes.
std::string baseName(const std::string& name) {
  std::string base = name.substr(name.find_last_of("/\\") + 1);
  if (const size_t dot = base.rfind('.'); dot != std::string::npos && dot > 0) base.resize(dot);
  for (char& c : base)
    if (std::string_view("<>:\"|?*").find(c) != std::string_view::npos) c = '_';
  constexpr size_t kLongest = 100;
  if (base.size() > kLongest) {
    base.resize(kLongest);
    while (!base.empty() && (static_cast<uint8_t>(base.back()) & 0xc0) == 0x80) base.pop_back();
    if (!base.empty() && static_cast<uint8_t>(base.back()) >= 0xc0) base.pop_back();
  }
  return base.empty() ? "texture" : base;
}

}  // namespace

TextureSet exportTextures(const Reader& reader, const std::filesystem::path& mesh) {
  TextureSet set = reader.textures();
  std::set<std::string> taken;
  for (Texture& texture : set.textures) {
    if (texture.name.empty()) texture.name = "missing";
    if (texture.tiles.empty()) continue;
    const std::string stem = mesh.stem().string() + "_" + baseName(texture.name);
    std::string name = stem + ".png";
    for (int copy = 2; !taken.insert(name).second; ++copy) name = stem + "-" + std::to_string(copy) + ".png";
    exportImage(reader, texture, mesh.parent_path() / name);
    texture.name = name;
  }
  return set;
}

}  // namespace lode::store
