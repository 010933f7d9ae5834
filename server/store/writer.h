#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/codec/hierarchy_page.h"
#include "common/codec/model_summary.h"
#include "common/codec/texture_set.h"
#include "common/io/atomic_file.h"
#include "server/store/format.h"

namespace lode::store {

/// Writes one store. The caller adds payloads in the order in which they shall lie in the file (coarse first,
/// siblings together), then finishes with the nodes; pages, blob table, footer and header are written then,
/// and the file appears under its name. Destroyed before, it leaves nothing behind. Not thread safe.
class Writer {
 public:
  /// @param temporary  see AtomicFile. @throws Error kIo.
  explicit Writer(const std::filesystem::path& path, const std::filesystem::path& temporary = {});

  /// Equal bytes give the same blob; no bytes give no blob. @throws Error kIo, kLimit.
  BlobRef addBlob(std::span<const std::byte> bytes);

  /// Adds the texture set, once at most, after its tiles. @throws Error kFormat if a tile was not added;
  /// kIo, kLimit.
  void addTextures(const TextureSet& textures);

  /// Checks the hierarchy as a reader will, writes what is left and puts the file under its name. Nothing can
  /// be added afterwards.
  /// @param summary  lattice, attributes, dropped, triangles_per_node are read from it; the rest is counted
  /// here.
  /// @param nodes    all nodes in key order, without child pages; they are filled in.
  /// @return the summary as a reader will see it. @throws Error kIo, kFormat, kLimit.
  ModelSummary finish(ModelSummary summary, std::vector<Node> nodes);

 private:
  struct NameHash {
    size_t operator()(const Digest& name) const noexcept;
  };

  BlobRef append(std::span<const std::byte> bytes, const Digest& name);
  bool wasAdded(const BlobRef& ref) const;
  void checkUse(std::span<const Node> nodes) const;
  BlobRef writePages(std::vector<Node> nodes);

  AtomicFile file_;
  std::filesystem::path path_;
  std::vector<TableEntry> entries_;
  std::unordered_map<Digest, uint32_t, NameHash> numbers_;
  BlobRef textures_;
  std::vector<uint32_t> tiles_;  ///< numbers of their blobs
};

}  // namespace lode::store
