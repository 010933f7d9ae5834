#include "client/web/core/job_codec.h"

#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "client/core/textures/tile.h"
#include "common/codec/texture_set.h"
#include "common/error.h"

namespace lode::web {
namespace {

/// Appends values and arrays to a message.
class Writer {
 public:
  template <typename T>
  void value(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  template <typename T>
  void array(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    value(static_cast<uint32_t>(values.size()));
    const auto bytes = std::as_bytes(values);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// Reads what Writer has written.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
  T value() {
    T value{};
    std::memcpy(&value, next(sizeof value), sizeof value);
    return value;
  }
  template <typename T>
  std::vector<T> array() {
    const uint64_t count = value<uint32_t>();
    const std::byte* const from = next(count * sizeof(T));
    std::vector<T> values(static_cast<size_t>(count));
    if (count > 0) std::memcpy(values.data(), from, values.size() * sizeof(T));
    return values;
  }
  void finish() const {
    if (!bytes_.empty()) refuse();
  }

 private:
  [[noreturn]] static void refuse() {
    throw Error(ErrorCode::kFormat, "a message of a decode worker is damaged; reload the page");
  }
  const std::byte* next(uint64_t bytes) {
    if (bytes > bytes_.size()) refuse();
    const std::byte* const from = bytes_.data();
    bytes_ = bytes_.subspan(static_cast<size_t>(bytes));
    return from;
  }

  std::span<const std::byte> bytes_;
};

struct TextureSize {
  uint32_t width = 0, height = 0;
};

void writeTextures(Writer& out, const TextureSet* set) {
  out.value(static_cast<uint8_t>(set != nullptr));
  if (set == nullptr) return;
  out.value(set->uv_origin);
  out.value(set->uv_scale_exponent);
  std::vector<TextureSize> sizes;
  for (const Texture& texture : set->textures) sizes.push_back({texture.width, texture.height});
  out.array(std::span<const TextureSize>(sizes));
}

std::shared_ptr<const TextureSet> readTextures(Reader& in) {
  if (in.value<uint8_t>() == 0) return nullptr;
  auto set = std::make_shared<TextureSet>();
  set->uv_origin = in.value<glm::dvec2>();
  set->uv_scale_exponent = in.value<int32_t>();
  for (const TextureSize& size : in.array<TextureSize>())
    set->textures.push_back({{}, size.width, size.height, {}});
  return set;
}

void writeMesh(Writer& out, const Mesh& mesh) {
  out.value(mesh.attributes);
  out.array(std::span(mesh.positions));
  out.array(std::span(mesh.vertex_attributes));
  out.array(std::span(mesh.triangles));
  out.array(std::span(mesh.cluster_boxes));
}

std::shared_ptr<const Mesh> readMesh(Reader& in) {
  auto mesh = std::make_shared<Mesh>();
  mesh->attributes = in.value<AttributeSet>();
  mesh->positions = in.array<PositionCode>();
  mesh->vertex_attributes = in.array<VertexAttributes>();
  mesh->triangles = in.array<glm::u32vec3>();
  mesh->cluster_boxes = in.array<LatticeBox>();
  return mesh;
}

void writeImage(Writer& out, const TileImage& image) {
  out.value(static_cast<uint32_t>(1 + image.coarser.size()));
  const auto write = [&](const TileImage& level) {
    out.value(level.size);
    out.array(std::span(level.texels));
  };
  write(image);
  for (const TileImage& level : image.coarser) write(level);
}

std::shared_ptr<const TileImage> readImage(Reader& in) {
  const auto levels = in.value<uint32_t>();
  const auto read = [&] {
    TileImage level;
    level.size = in.value<glm::uvec2>();
    level.texels = in.array<glm::u8vec4>();
    return level;
  };
  auto image = std::make_shared<TileImage>(read());
  for (uint32_t i = 1; i < levels; ++i) image->coarser.push_back(read());
  return image;
}

void writeFootprint(Writer& out, const core::TextureFootprint& footprint) {
  out.array(std::span(footprint.tiles));
  out.array(std::span(footprint.whole));
}

std::shared_ptr<const core::TextureFootprint> readFootprint(Reader& in) {
  auto footprint = std::make_shared<core::TextureFootprint>();
  footprint->tiles = in.array<core::TouchedTile>();
  footprint->whole = in.array<core::WornTexture>();
  return footprint;
}

}  // namespace

Bytes encodeJob(uint32_t number, const core::DecodeJob& job) {
  Writer out;
  out.value(number);
  out.value(job.use.kind);
  out.value(job.step);
  out.value(job.expected);
  out.value(job.image_size);
  out.value(static_cast<uint8_t>(job.with_tail));
  writeTextures(out, job.textures.get());
  out.array(std::span(job.bytes));
  return out.take();
}

JobMessage decodeJob(std::span<const std::byte> message) {
  Reader in(message);
  JobMessage decoded;
  decoded.number = in.value<uint32_t>();
  core::DecodeJob& job = decoded.job;
  job.use.kind = in.value<core::BlobKind>();
  job.step = in.value<double>();
  job.expected = in.value<PayloadExpectation>();
  job.image_size = in.value<glm::uvec2>();
  job.with_tail = in.value<uint8_t>() != 0;
  job.textures = readTextures(in);
  job.bytes = in.array<std::byte>();
  in.finish();
  return decoded;
}

core::DecodeResult takeImage(const core::DecodeJob& job, std::span<const uint8_t> texels, glm::uvec2 size) {
  core::DecodeResult result;
  if (texels.empty() || size != job.image_size) {
    result.failure = texels.empty() ? "the browser cannot decode a texture tile"
                                    : "a texture tile has another size than its texture set says";
    return result;
  }
  TileImage image{size, std::vector<glm::u8vec4>(size_t{size.x} * size.y), {}};
  std::memcpy(image.texels.data(), texels.data(), texels.size());
  if (job.with_tail) core::makeTail(image);
  result.image = std::make_shared<const TileImage>(std::move(image));
  return result;
}

Bytes encodeResult(uint32_t number, const core::DecodeResult& result) {
  Writer out;
  out.value(number);
  out.array(std::span<const char>(result.failure));
  const uint8_t has =
      uint8_t(result.decoded ? 1 : 0) | uint8_t(result.image ? 2 : 0) | uint8_t(result.footprint ? 4 : 0);
  out.value(has);
  if (result.decoded) writeMesh(out, *result.decoded);
  if (result.image) writeImage(out, *result.image);
  if (result.footprint) writeFootprint(out, *result.footprint);
  return out.take();
}

ResultMessage decodeResult(std::span<const std::byte> message) {
  Reader in(message);
  ResultMessage decoded;
  decoded.number = in.value<uint32_t>();
  const std::vector<char> failure = in.array<char>();
  decoded.result.failure.assign(failure.begin(), failure.end());
  const auto has = in.value<uint8_t>();
  if ((has & 1) != 0) decoded.result.decoded = readMesh(in);
  if ((has & 2) != 0) decoded.result.image = readImage(in);
  if ((has & 4) != 0) decoded.result.footprint = readFootprint(in);
  in.finish();
  return decoded;
}

}  // namespace lode::web
