#include "server/ingest/textures.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <fstream>
#include <thread>

#include "common/error.h"
#include "common/printable.h"
#include "common/texture_set.h"
#include "server/ingest/ply_input.h"
#include "server/ingest/tile_encoder.h"

namespace lode::ingest {
namespace {

constexpr size_t kTilesAtOnce = 8;  ///< a thread, before they are written

bool isInside(const std::filesystem::path& path, const std::filesystem::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

/// A name that a texture set takes.
std::string presentable(std::string name) {
  name.resize(std::min<size_t>(name.size(), kMaxTextureNameBytes));
  if (isPrintableUtf8(name)) return name;
  for (char& c : name)
    if (const auto byte = static_cast<unsigned char>(c); byte < ' ' || byte >= 0x7f) c = '?';
  return name;
}

std::vector<std::byte> readFile(const std::filesystem::path& path, uint64_t memory_bytes) {
  const uint64_t size = std::filesystem::file_size(path);
  if (size > memory_bytes / 2)
    throw Error(ErrorCode::kLimit, "has " + std::to_string(size) + " bytes; raise --memory or scale it down");
  std::vector<std::byte> bytes(size);
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    throw Error(ErrorCode::kInput, "cannot be read; check the file and its permissions");
  return bytes;
}

/// Runs work(0) ... work(count - 1) on threads; throws what the first that failed met.
template <typename Work>
void forEach(size_t count, unsigned threads, const Work& work) {
  std::atomic<size_t> next{0};
  std::vector<std::exception_ptr> failures(count);
  {
    std::vector<std::jthread> workers;
    for (size_t t = 0; t < std::min<size_t>(threads, count); ++t)
      workers.emplace_back([&] {
        for (size_t i = next++; i < count; i = next++) {
          try {
            work(i);
          } catch (...) {
            failures[i] = std::current_exception();
          }
        }
      });
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

class Stager {
 public:
  Stager(const BuildOptions& options, Spool& tiles, uint64_t memory_bytes, const BuildProgress& progress,
         std::vector<std::string>& warnings, size_t textures)
      : options_(options),
        tiles_(tiles),
        memory_bytes_(memory_bytes),
        progress_(progress),
        warnings_(warnings),
        textures_(textures) {}

  StagedTextures::Texture stage(const std::string& name) {
    StagedTextures::Texture staged{presentable(name), 0, 0, {}};
    const std::string quoted = options_.input.string() + ": texture " + quotedText(name, 4096);
    const TextureFile file = findTexture(options_.input, name);
    if (!file.problem.empty()) {
      warnings_.push_back(quoted + " " + file.problem);
    } else {
      try {
        addLevels(readImage(file.path, quoted), staged);
      } catch (const Error& error) {
        const std::string text = quoted + " " + error.what();
        if (error.code() != ErrorCode::kInput) throw Error(error.code(), text);
        warnings_.push_back(text + "; it is built without");
      }
    }
    ++done_textures_;
    return staged;
  }

 private:
  Image readImage(const std::filesystem::path& path, const std::string& quoted) {
    const std::vector<std::byte> file = readFile(path, memory_bytes_);
    std::string damage;
    Image image = decodeImage(file, memory_bytes_ - file.size(), damage);
    if (!damage.empty())
      warnings_.push_back(quoted + " is damaged (" + damage + "): what could be read of it is used");
    return image;
  }

  void addLevels(Image image, StagedTextures::Texture& staged) {
    staged.width = image.size.x;
    staged.height = image.size.y;
    const lode::Texture shape{{}, staged.width, staged.height, {}};
    staged.tiles.resize(tileCount(shape));
    codec_ = chooseCodec(image);
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
      files.assign(std::min(count - done, kTilesAtOnce * options_.threads), {});
      forEach(files.size(), options_.threads, [&](size_t i) {
        const auto number = static_cast<uint32_t>(done + i);
        const glm::uvec2 tile(number % across, number / across);
        const glm::ivec2 corner(tile * kTileInnerPx);
        files[i] = encodeTile(cutOut(image, corner - glm::ivec2(kTileGutterPx),
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
  const uint64_t memory_bytes_;
  const BuildProgress& progress_;
  std::vector<std::string>& warnings_;
  const size_t textures_;
  size_t done_textures_ = 0;
  TileCodec codec_ = TileCodec::kJpeg;
  size_t staged_tiles_ = 0;  ///< of the texture at hand
  uint64_t all_tiles_ = 0;
};

/// Says where a wide range of coordinates makes them coarser than the images.
void checkPrecision(const StagedTextures& staged, const std::string& ply,
                    std::vector<std::string>& warnings) {
  uint32_t largest = 0;
  for (const StagedTextures::Texture& texture : staged.textures)
    largest = std::max({largest, texture.width, texture.height});
  const double texels = std::ldexp(largest, staged.grid.scale_exponent - 16);
  if (texels <= 1) return;
  warnings.push_back(ply + ": texture coordinates run over " +
                     std::to_string(1ull << staged.grid.scale_exponent) +
                     " repetitions of the image, and are rounded to " + std::to_string(texels) +
                     " pixels of it; bring them nearer to 0 ... 1 where that shows");
}

}  // namespace

TextureFile findTexture(const std::filesystem::path& ply, const std::string& name) {
  const std::filesystem::path relative(name);
  const auto is_up = [](const std::filesystem::path& part) { return part == ".."; };
  if (relative.is_absolute() || std::any_of(relative.begin(), relative.end(), is_up))
    return {{}, "is outside the PLY file's folder; put it there and name it without a path"};
  std::error_code failed;
  const std::filesystem::path folder =
      std::filesystem::canonical(ply.has_parent_path() ? ply.parent_path() : ".", failed);
  if (failed) return {{}, "is not there; put it into the PLY file's folder"};
  const std::filesystem::path path = std::filesystem::canonical(folder / relative, failed);
  if (failed || !std::filesystem::exists(path, failed))
    return {{}, "is not there; put it into the PLY file's folder"};
  if (!isInside(path, folder))
    return {{}, "is a link out of the PLY file's folder; put the image itself there"};
  if (!std::filesystem::is_regular_file(path, failed)) return {{}, "is no file; put the image there"};
  return {path, {}};
}

void StagedTextures::save(RecordWriter& record) const {
  record.put(grid);
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
  staged.grid = record.get<UvGrid>();
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

StagedTextures stageTextures(const BuildOptions& options, std::span<const std::string> names,
                             const UvGrid& grid, Spool& tiles, uint64_t memory_bytes,
                             const BuildProgress& progress, std::vector<std::string>& warnings) {
  if (names.size() > kMaxTextures)
    throw Error(ErrorCode::kInput, options.input.string() + ": " + std::to_string(names.size()) +
                                       " texture files, the limit is " + std::to_string(kMaxTextures) +
                                       "; join some of them");
  StagedTextures staged{grid, {}};
  Stager stager(options, tiles, memory_bytes, progress, warnings, names.size());
  for (const std::string& name : names) staged.textures.push_back(stager.stage(name));
  tiles.flush();
  checkPrecision(staged, options.input.string(), warnings);
  return staged;
}

}  // namespace lode::ingest
