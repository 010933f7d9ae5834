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

/// Writes one store. Add payloads in file order (coarse nodes first, siblings together), then call finish()
/// with the nodes. A writer that is destroyed before finish() leaves no file behind. Not thread safe.
class Writer {
 public:
  /// @param temporary  see AtomicFile. @throws Error kIo.
  explicit Writer(const std::filesystem::path& path, const std::filesystem::path& temporary = {});

  /// Adds a blob. If an earlier blob has equal bytes, returns the earlier blob instead. If `bytes` is empty,
  /// adds nothing and returns an empty reference. @throws Error kIo, kLimit.
  BlobRef addBlob(std::span<const std::byte> bytes);

  /// Adds the texture set. Call at most once, after adding its tiles. @throws Error kFormat if a tile was not
  /// added; kIo, kLimit.
  void addTextures(const TextureSet& textures);

  /// Checks the hierarchy as a reader does. Writes pages, blob table, footer and header, then renames the
  /// file into place. Call it last.
  /// @param summary  only lattice, attributes, dropped and triangles_per_node are read; the function computes
  /// the rest.
  /// @param nodes    all nodes in key order; the function sets their child pages.
  /// @return the summary as a reader sees it. @throws Error kIo, kFormat, kLimit.
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
  std::vector<uint32_t> tiles_;  ///< blob numbers of texture tiles
};

}  // namespace lode::store
