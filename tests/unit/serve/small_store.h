#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "server/store/writer.h"
#include "tests/support/work_folder.h"

namespace lode::serve::test {

using lode::test::WorkFolder;

/// Writes a store of a root with eight leaves. Payloads are random bytes, because a server never decodes
/// them: the root's LODs have 150,000 (or the given number) and 9,000 bytes, the leaves' about 40,000.
inline ModelSummary writeSmallStore(const std::filesystem::path& path, uint32_t seed = 1,
                                    size_t root_bytes = 150'000) {
  std::mt19937 random(seed);
  store::Writer writer(path);
  const auto lod = [&](size_t bytes, uint32_t triangles, float error_model) {
    std::vector<std::byte> payload(bytes);
    for (std::byte& byte : payload) byte = static_cast<std::byte>(random());
    return Lod{writer.addBlob(payload), triangles, triangles, 0, error_model, 0};
  };
  const LatticeBox box{{0, 0, 0}, {1000, 1000, 1000}};
  std::vector<Node> nodes{{kRootKey, box, 0xFF, {lod(root_bytes, 3000, 2), lod(9'000, 500, 4)}, 0, {}}};
  for (unsigned octant = 0; octant < 8; ++octant)
    nodes.push_back({kRootKey.child(octant), box, 0, {lod(40'000 + octant, 1000, 1)}, 0, {}});
  ModelSummary summary;
  summary.name = path.stem().string();
  summary.box = box;
  summary.triangles = 8000;
  summary.triangles_per_node = 1000;
  return writer.finish(summary, nodes);
}

/// Changes one byte of a file in place.
inline void damage(const std::filesystem::path& path, uint64_t offset) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(offset));
  const int byte = file.get();
  file.seekp(static_cast<std::streamoff>(offset));
  file.put(static_cast<char>(byte ^ 0x40));
}

}  // namespace lode::serve::test
