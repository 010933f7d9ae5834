#include "server/sample/sample.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "common/error.h"
#include "common/io/atomic_file.h"
#include "server/sample/asteroid.h"
#include "server/sample/gyroid.h"
#include "server/sample/sample_model.h"
#include "server/sample/terrain.h"

namespace lode::ingest {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY records are written in native byte order");

constexpr uint64_t kMaxTriangles = 4'000'000'000;  // limit that keeps vertex indices below 2^31
constexpr uint8_t kAllowed = AttributeSet::kNormal | AttributeSet::kColour | AttributeSet::kTexture;

using Bytes = std::vector<std::byte>;

struct Kind {
  const char* name;
  uint64_t least_triangles;
  std::unique_ptr<SampleModel> (*make)(uint64_t triangles, uint64_t seed, AttributeSet attributes);
};

constexpr std::array<Kind, 3> kKinds{{
    {"asteroid", kLeastAsteroid, makeAsteroid},
    {"gyroid", kLeastGyroid, makeGyroid},
    {"terrain", kLeastTerrain, makeTerrain},
}};

std::unique_ptr<SampleModel> makeModel(const SampleOptions& options) {
  const auto kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& each) { return options.kind == each.name; });
  if (kind == kKinds.end()) {
    throw Error(ErrorCode::kUsage,
                "unknown kind of sample '" + options.kind + "'; use asteroid, gyroid or terrain");
  }
  if (options.triangles < kind->least_triangles || options.triangles > kMaxTriangles) {
    throw Error(ErrorCode::kUsage, "the sample " + options.kind + " cannot have " +
                                       std::to_string(options.triangles) + " triangles; ask for " +
                                       std::to_string(kind->least_triangles) + " to " +
                                       std::to_string(kMaxTriangles));
  }
  if ((options.attributes.bits & ~kAllowed) != 0) {
    throw Error(ErrorCode::kUsage, "a sample has no such attribute; use normal, color or uv");
  }
  return kind->make(options.triangles, options.seed, options.attributes);
}

std::string headerOf(const SampleOptions& options, const SampleModel& model) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment " + options.kind + ", seed " +
                       std::to_string(options.seed) + "\nelement vertex " + std::to_string(model.vertices()) +
                       "\nproperty float x\nproperty float y\nproperty float z\n";
  if (options.attributes.has(AttributeSet::kNormal)) {
    header += "property float nx\nproperty float ny\nproperty float nz\n";
  }
  if (options.attributes.has(AttributeSet::kColour)) {
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  }
  if (options.attributes.has(AttributeSet::kTexture)) header += "property float s\nproperty float t\n";
  return header + "element face " + std::to_string(model.triangles()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

template <class T>
void put(Bytes& to, const T& value) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  to.insert(to.end(), bytes.begin(), bytes.end());
}

Bytes vertexRows(const SampleModel& model, AttributeSet attributes, uint64_t block) {
  std::vector<SampleVertex> vertices;
  model.addVertices(block, vertices);
  Bytes bytes;
  bytes.reserve(vertices.size() * 35);
  for (const SampleVertex& vertex : vertices) {
    put(bytes, vertex.position);
    if (attributes.has(AttributeSet::kNormal)) put(bytes, vertex.normal);
    if (attributes.has(AttributeSet::kColour)) put(bytes, vertex.colour);
    if (attributes.has(AttributeSet::kTexture)) put(bytes, vertex.uv);
  }
  return bytes;
}

Bytes faceRows(const SampleModel& model, uint64_t block) {
  std::vector<glm::u32vec3> triangles;
  model.addTriangles(block, triangles);
  Bytes bytes;
  bytes.reserve(triangles.size() * 13);
  for (const glm::u32vec3& triangle : triangles) {
    put(bytes, uint8_t{3});
    put(bytes, triangle);
  }
  return bytes;
}

/// Computes blocks on several threads and writes them in order. At most `threads` blocks are in memory.
void writeBlocks(AtomicFile& file, uint64_t blocks, unsigned threads,
                 const std::function<Bytes(uint64_t)>& compute) {
  std::deque<std::future<Bytes>> under_way;
  for (uint64_t next = 0; next < blocks || !under_way.empty();) {
    while (next < blocks && under_way.size() < threads) {
      under_way.push_back(std::async(std::launch::async, compute, next++));
    }
    file.write(under_way.front().get());
    under_way.pop_front();
  }
}

}  // namespace

uint64_t writeSample(const SampleOptions& options, const std::filesystem::path& path) {
  const std::unique_ptr<SampleModel> model = makeModel(options);
  const unsigned threads =
      options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  const std::string header = headerOf(options, *model);
  AtomicFile file(path);
  file.write(std::as_bytes(std::span(header)));
  writeBlocks(file, model->blocks(), threads,
              [&](uint64_t block) { return vertexRows(*model, options.attributes, block); });
  writeBlocks(file, model->blocks(), threads, [&](uint64_t block) { return faceRows(*model, block); });
  file.commit();
  return model->triangles();
}

}  // namespace lode::ingest
