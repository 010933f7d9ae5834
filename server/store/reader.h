#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "common/codec/hierarchy_page.h"
#include "common/codec/model_summary.h"
#include "common/codec/texture_set.h"

namespace lode::store {

/// Place of a blob in the file.
struct BlobEntry {
  uint64_t offset = 0;
  uint32_t bytes = 0;
  uint64_t checksum = 0;
  Digest digest;
};

/// An open store with its summary, whole hierarchy, textures and blob table. The constructor validates all of
/// them. Const functions are thread safe.
class Reader {
 public:
  /// @throws Error kIo, kInput (not a store, or a store of another version), kFormat or kLimit. The message
  /// names the file, the place and the remedy.
  explicit Reader(const std::filesystem::path& path);
  ~Reader();
  Reader(Reader&&) noexcept;

  const ModelSummary& summary() const noexcept;
  const std::filesystem::path& path() const noexcept;
  /// Returns all nodes, in key order.
  std::span<const Node> nodes() const noexcept;
  /// Returns the textures of the store, or an empty set if the store has none.
  const TextureSet& textures() const noexcept;
  /// Returns the node with a key; null if the store has no such node.
  const Node* find(NodeKey key) const noexcept;
  /// Returns the number of blobs. Blob numbers start at 1.
  uint32_t blobCount() const noexcept;
  /// Returns the place of a blob. @throws Error kFormat if the store has no such blob.
  const BlobEntry& blob(uint32_t number) const;
  /// Reads a blob and checks its checksum. @throws Error kIo or kFormat.
  std::vector<std::byte> readBlob(uint32_t number) const;
  /// Returns the file descriptor, for servers that read blobs themselves. The file stays open as long as the
  /// reader exists.
  int fileDescriptor() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lode::store
