// Writes a store of about 1,500 random blobs of equal size, and a file with the bytes of each blob for a file
// server: serving_store BLOB_BYTES OUT.lode FILES_FOLDER. Prints the numbers of the first and last payload.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "common/error.h"
#include "server/store/writer.h"

namespace {

using namespace lode;

constexpr int kDepth = 3;
constexpr uint32_t kInnerLods = 14;  ///< LODs of each of the 73 inner nodes; the 512 leaves have one LOD

class StoreOfNoise {
 public:
  StoreOfNoise(const std::filesystem::path& path, std::filesystem::path files, size_t blob_bytes)
      : writer_(path), files_(std::move(files)), blob_bytes_(blob_bytes) {}

  void write() {
    for (int depth = 0; depth <= kDepth; ++depth) addLevel(kRootKey, depth);
    ModelSummary summary;
    summary.box = box_;
    summary.triangles = summary.triangles_per_node = 1u << 20;
    writer_.finish(summary, nodes_);
    std::printf("{\"first\": %u, \"last\": %u}\n", first_, last_);
  }

 private:
  void addLevel(NodeKey node, int depth) {
    if (node.depth() < depth) {
      for (unsigned octant = 0; octant < 8; ++octant) addLevel(node.child(octant), depth);
      return;
    }
    const bool leaf = depth == kDepth;
    std::vector<Lod> lods;
    for (uint32_t i = 0; i < (leaf ? 1 : kInnerLods); ++i)
      lods.push_back(lod(static_cast<float>(100 * (kDepth - depth)) + static_cast<float>(i)));
    Node& made = nodes_.emplace_back();
    made.key = node;
    made.box = box_;
    made.child_mask = static_cast<uint8_t>(leaf ? 0 : 0xFF);
    made.lods = std::move(lods);
  }

  Lod lod(float error_model) {
    std::vector<std::byte> blob(blob_bytes_);
    for (std::byte& byte : blob) byte = static_cast<std::byte>(random_());
    const BlobRef ref = writer_.addBlob(blob);
    if (first_ == 0) first_ = ref.number;
    last_ = ref.number;
    std::ofstream file(files_ / std::to_string(ref.number), std::ios::binary);
    file.write(reinterpret_cast<const char*>(blob.data()), static_cast<std::streamsize>(blob.size()));
    return {ref, 1000, 1000, 0, error_model, 0};
  }

  const LatticeBox box_{{0, 0, 0}, {1000, 1000, 1000}};
  store::Writer writer_;
  std::filesystem::path files_;
  size_t blob_bytes_;
  std::mt19937 random_{1};
  std::vector<Node> nodes_;
  uint32_t first_ = 0, last_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: serving_store BLOB_BYTES OUT.lode FILES_FOLDER\n");
    return 2;
  }
  try {
    StoreOfNoise store(argv[2], argv[3], std::strtoull(argv[1], nullptr, 10));
    store.write();
    return 0;
  } catch (const Error& error) {
    std::fprintf(stderr, "serving_store: %s\n", error.what());
    return 1;
  }
}
