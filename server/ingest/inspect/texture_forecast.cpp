#include "server/ingest/inspect/texture_forecast.h"

#include <algorithm>
#include <optional>
#include <string>

#include "common/codec/texture_set.h"
#include "common/error.h"
#include "server/ingest/plan/machine.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/store/tile_encoder.h"

namespace lode::ingest {
namespace {

/// Approximate number of texels to decode. If the images have fewer texels in total, all are decoded.
constexpr uint64_t kTrialTexels = 64 << 20;
constexpr uint32_t kTrialTiles = 4;  ///< number of tiles to encode per level
/// Typical memory of a decoded image, in bytes per texel: alone, and together with the next coarser level.
constexpr uint64_t kDecodedTexelBytes = 4, kLevelsTexelBytes = 5;
/// Typical encoder memory in bytes per texel of a tile, measured with photographs and noise.
constexpr uint64_t kEncoderTexelBytes = 10, kWebpEncoderTexelBytes = 26;

uint64_t texelsOf(const TextureImage& image) { return image.header.width * image.header.height; }

lode::Texture shapeOf(const TextureImage& image) {
  return {{}, static_cast<uint32_t>(image.header.width), static_cast<uint32_t>(image.header.height), {}};
}

uint64_t texelsOf(const lode::Texture& shape, uint32_t level) {
  const glm::u64vec2 size(levelSize(shape, level));
  return size.x * size.y;
}

/// Cost of one or more images.
struct Cost {
  double serial_cpu_seconds = 0, parallel_cpu_seconds = 0, tile_bytes = 0;
  uint64_t encoder_texel_bytes = 0;  ///< peak memory of the encoder, in bytes per texel

  Cost& operator+=(const Cost& other) {
    serial_cpu_seconds += other.serial_cpu_seconds;
    parallel_cpu_seconds += other.parallel_cpu_seconds;
    tile_bytes += other.tile_bytes;
    encoder_texel_bytes = std::max(encoder_texel_bytes, other.encoder_texel_bytes);
    return *this;
  }
  Cost times(double factor) const {
    return {serial_cpu_seconds * factor, parallel_cpu_seconds * factor, tile_bytes * factor,
            encoder_texel_bytes};
  }
};

/// Encodes some tiles of a level. @return the cost per texel.
Cost tryTiles(const Image& image, const lode::Texture& shape, uint32_t level, store::TileCodec codec) {
  const uint32_t across = tilesAcross(shape, level), count = across * tilesDown(shape, level);
  const uint32_t tried = std::min(count, kTrialTiles);
  const double start = cpuSeconds();
  Cost cost;
  uint64_t texels = 0;
  for (uint32_t i = 0; i < tried; ++i) {
    const auto number = static_cast<uint32_t>((2ull * i + 1) * count / (2ull * tried));
    const glm::uvec2 tile(number % across, number / across);
    const glm::uvec2 inner = tileInnerSize(shape, level, tile.x, tile.y);
    const glm::ivec2 corner(tile * kTileInnerPx);
    const Image part = cutOut(image, corner - glm::ivec2(kTileGutterPx), inner + 2 * kTileGutterPx);
    cost.tile_bytes += static_cast<double>(store::encodeTile(part, codec).size());
    texels += uint64_t{inner.x} * inner.y;
  }
  cost.parallel_cpu_seconds = cpuSeconds() - start;
  return cost.times(1 / static_cast<double>(texels));
}

/// Measures the cost of an image. @return nothing if the image cannot be read.
std::optional<Cost> tryImage(const TextureImage& given, uint64_t memory_bytes) {
  const lode::Texture shape = shapeOf(given);
  const auto texels = [&](uint32_t level) { return static_cast<double>(texelsOf(shape, level)); };
  double start = cpuSeconds();
  Image image;
  try {
    std::string damage;
    image = readImage(given.path, memory_bytes, damage);
  } catch (const Error&) {
    return std::nullopt;
  }
  if (image.size != glm::uvec2(given.header.width, given.header.height)) return std::nullopt;
  const store::TileCodec codec = store::chooseCodec(image);
  Cost cost;
  cost.encoder_texel_bytes = codec == store::TileCodec::kWebp ? kWebpEncoderTexelBytes : kEncoderTexelBytes;
  cost.serial_cpu_seconds = cpuSeconds() - start;
  cost += tryTiles(image, shape, 0, codec).times(texels(0));
  if (levelCount(shape) == 1) return cost;
  start = cpuSeconds();
  image = halved(image);
  const double halving = (cpuSeconds() - start) / texels(0);
  const Cost coarse = tryTiles(image, shape, 1, codec);
  for (uint32_t level = 1; level < levelCount(shape); ++level) {
    cost.serial_cpu_seconds += halving * texels(level - 1);
    cost += coarse.times(texels(level));
  }
  return cost;
}

/// Returns the peak memory of reading an image and encoding its tiles.
uint64_t usualMemory(const TextureImage& image, uint64_t encoder_texel_bytes, uint64_t memory_bytes,
                     unsigned threads) {
  const lode::Texture shape = shapeOf(image);
  const uint64_t texels = texelsOf(image);
  const glm::u64vec2 tile(tileInnerSize(shape, 0, 0, 0));
  const uint64_t at_once = encoderThreads(memory_bytes, image.memoryBytes(), threads) * tile.x * tile.y;
  const uint64_t encoders = encoder_texel_bytes * std::min(at_once, texels);
  // Subtract the coarser levels, which memoryBytes() includes, because they are made only after the decoder
  // has freed its memory.
  const uint64_t decoding = image.memoryBytes() - 2 * texels;
  const bool is_halved = levelCount(shape) > 1;
  return std::max(decoding, texels * (is_halved ? kLevelsTexelBytes : kDecodedTexelBytes) + encoders);
}

}  // namespace

TextureForecast forecastTextures(std::span<const TextureImage> images, uint64_t memory_bytes,
                                 unsigned threads) {
  const uint64_t image_bytes = planMemory(memory_bytes, threads, 1).image_bytes;
  uint64_t all = 0, passed = 0, tried = 0;
  for (const TextureImage& image : images) all += texelsOf(image);
  Cost cost;
  const uint64_t stride = std::max(all / kTrialTexels, uint64_t{1});
  for (const TextureImage& image : images) {
    if (!image.problem.empty()) continue;
    // Choose the images so that the decoded texels are spread evenly over all images.
    const bool is_due = tried * stride <= passed;
    passed += texelsOf(image);
    if (!is_due) continue;
    if (const auto one = tryImage(image, image_bytes)) {
      cost += *one;
      tried += texelsOf(image);
    }
  }
  TextureForecast forecast;
  if (tried == 0) return forecast;
  cost = cost.times(static_cast<double>(all) / static_cast<double>(tried));
  forecast.serial_cpu_seconds = cost.serial_cpu_seconds;
  forecast.parallel_cpu_seconds = cost.parallel_cpu_seconds;
  forecast.tile_bytes = static_cast<uint64_t>(cost.tile_bytes);
  for (const TextureImage& image : images)
    if (image.problem.empty())
      forecast.memory_bytes = std::max(forecast.memory_bytes,
                                       usualMemory(image, cost.encoder_texel_bytes, memory_bytes, threads));
  return forecast;
}

}  // namespace lode::ingest
