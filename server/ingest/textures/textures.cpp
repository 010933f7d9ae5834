#include "server/ingest/textures/textures.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "common/printable.h"
#include "common/start_thread.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/store/tile_encoder.h"

namespace lode::ingest {
namespace {

constexpr size_t kTilesAtOnce = 8;  ///< tiles encoded per thread before they are written

/// Changes a name so that it is valid in a texture set.
std::string presentable(std::string name) {
  name.resize(std::min<size_t>(name.size(), kMaxTextureNameBytes));
  if (isPrintableUtf8(name)) return name;
  for (char& c : name)
    if (const auto byte = static_cast<unsigned char>(c); byte < ' ' || byte >= 0x7f) c = '?';
  return name;
}

/// Runs work(0) ... work(count - 1) on threads. If calls throw, rethrows the exception of the smallest index.
template <typename Work>
void forEach(size_t count, unsigned threads, const Work& work) {
  std::atomic<size_t> next{0};
  std::vector<std::exception_ptr> failures(count);
  const auto workSome = [&] {
    for (size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
  };
  startThreads(std::min<size_t>(threads, count), "for textures", workSome).clear();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

class Stager {
 public:
  Stager(const BuildOptions& options, Spool& tiles, uint64_t image_bytes, const BuildProgress& progress,
         std::vector<std::string>& warnings, size_t textures)
      : options_(options),
        tiles_(tiles),
        image_bytes_(image_bytes),
        progress_(progress),
        warnings_(warnings),
        textures_(textures) {}

  StagedTextures::Texture stage(const TextureImage& image) {
    StagedTextures::Texture staged{presentable(image.name), 0, 0, {}};
    const std::string words = textureInWords(image.ply, image.name);
    std::string problem = image.problem;
    threads_ = encoderThreads(options_.memory_bytes, image.memoryBytes(), options_.threads);
    if (problem.empty()) {
      try {
        std::string damage;
        addLevels(readImage(image.path, image_bytes_, damage), staged);
        if (!damage.empty()) warnings_.push_back(words + " " + damage);
      } catch (const Error& error) {
        if (error.code() != ErrorCode::kInput) throw Error(error.code(), words + " " + error.what());
        problem = error.what();
      }
    }
    if (!problem.empty()) warnings_.push_back(words + " " + problem + "; the build leaves it out");
    ++done_textures_;
    return staged;
  }

 private:
  void addLevels(Image image, StagedTextures::Texture& staged) {
    staged.width = image.size.x;
    staged.height = image.size.y;
    const lode::Texture shape{{}, staged.width, staged.height, {}};
    staged.tiles.resize(tileCount(shape));
    codec_ = store::chooseCodec(image);
    staged_tiles_ = 0;
    for (uint32_t level = 0; level < levelCount(shape); ++level) {
      if (level > 0) image = halved(image);
      addTiles(image, shape, level, staged.tiles);
    }
  }

  void addTiles(const Image& image, const lode::Texture& shape, uint32_t level,
                std::vector<StagedTextures::Place>& places) {
    const uint32_t across = tilesAcross(shape, level);
    const size_t first = tileIndex(shape, level, 0, 0), count = size_t{across} * tilesDown(shape, level);
    std::vector<std::vector<std::byte>> files;
    for (size_t done = 0; done < count; done += files.size()) {
      files.assign(std::min(count - done, kTilesAtOnce * threads_), {});
      forEach(files.size(), threads_, [&](size_t i) {
        const auto number = static_cast<uint32_t>(done + i);
        const glm::uvec2 tile(number % across, number / across);
        const glm::ivec2 corner(tile * kTileInnerPx);
        files[i] = store::encodeTile(cutOut(image, corner - glm::ivec2(kTileGutterPx),
                                            tileInnerSize(shape, level, tile.x, tile.y) + 2 * kTileGutterPx),
                                     codec_);
      });
      for (size_t i = 0; i < files.size(); ++i) {
        places[first + done + i] = {tiles_.size(), static_cast<uint32_t>(files[i].size())};
        tiles_.append(std::span<const std::byte>(files[i]));
      }
      report(files.size(), places.size());
    }
  }

  void report(size_t tiles, size_t of_texture) {
    staged_tiles_ += tiles;
    all_tiles_ += tiles;
    const double fraction = static_cast<double>(staged_tiles_) / static_cast<double>(of_texture);
    if (progress_)
      progress_("textures", (static_cast<double>(done_textures_) + fraction) / static_cast<double>(textures_),
                all_tiles_, 0);
  }

  const BuildOptions& options_;
  Spool& tiles_;
  const uint64_t image_bytes_;
  const BuildProgress& progress_;
  std::vector<std::string>& warnings_;
  const size_t textures_;
  size_t done_textures_ = 0;
  /// State of the current texture: threads that encode it, format of its tiles, and tiles encoded so far.
  unsigned threads_ = 1;
  store::TileCodec codec_ = store::TileCodec::kJpeg;
  size_t staged_tiles_ = 0;
  uint64_t all_tiles_ = 0;
};

/// Warns if a wide range of texture coordinates makes their grid coarser than the pixels of the largest
/// image.
void checkPrecision(const StagedTextures& staged, const UvGrid& grid, const std::string& ply,
                    std::vector<std::string>& warnings) {
  uint32_t largest = 0;
  for (const StagedTextures::Texture& texture : staged.textures)
    largest = std::max({largest, texture.width, texture.height});
  const double texels = std::ldexp(largest, grid.scale_exponent - 16);
  if (texels <= 1) return;
  warnings.push_back(ply + ": texture coordinates cover " + std::to_string(1ull << grid.scale_exponent) +
                     " repetitions of the image and are rounded to " + std::to_string(texels) +
                     " of its pixels; if that is visible, move them closer to 0..1");
}

}  // namespace

void StagedTextures::save(RecordWriter& record) const {
  record.put(static_cast<uint32_t>(textures.size()));
  for (const Texture& texture : textures) {
    record.putText(texture.name);
    record.put(texture.width);
    record.put(texture.height);
    record.putAll(texture.tiles);
  }
}

StagedTextures StagedTextures::load(RecordReader& record) {
  StagedTextures staged;
  for (auto count = record.get<uint32_t>(); count > 0; --count) {
    Texture texture;
    texture.name = record.getText();
    texture.width = record.get<uint32_t>();
    texture.height = record.get<uint32_t>();
    texture.tiles = record.getAll<Place>();
    staged.textures.push_back(std::move(texture));
  }
  return staged;
}

StagedTextures stageTextures(const BuildOptions& options, std::span<const TextureImage> images,
                             const UvGrid& grid, Spool& tiles, uint64_t image_bytes,
                             const BuildProgress& progress) {
  StagedTextures staged;
  Stager stager(options, tiles, image_bytes, progress, staged.warnings, images.size());
  for (const TextureImage& image : images) staged.textures.push_back(stager.stage(image));
  tiles.flush();
  checkPrecision(staged, grid, options.input.string(), staged.warnings);
  return staged;
}

}  // namespace lode::ingest
