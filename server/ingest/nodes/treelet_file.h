#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/codec/running_checksum.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/nodes/built_node_record.h"

namespace lode::ingest {

/// Place of a record in a treelet's file.
struct RecordPlace {
  uint64_t offset = 0, bytes = 0;
};

/// A node, and the place of its record, which putFinishedNode() wrote.
struct NodePlace {
  NodeKey key;
  RecordPlace record;
};

/// A finished treelet on disk: the payloads of its nodes, the nodes, and the data of its root that the parent
/// of the root needs. Keeps no file open. Const functions are thread safe and throw Error kIo, kFormat.
class TreeletFile {
 public:
  /// Opens a finished treelet, after comparing the whole file with its checksum.
  /// @return nothing if the file is missing, incomplete or damaged.
  static std::optional<TreeletFile> open(const std::filesystem::path& path);

  const std::filesystem::path& path() const noexcept { return path_; }
  uint64_t bytes() const noexcept { return bytes_; }  ///< size of the file
  /// Returns all nodes of the treelet, in any order.
  std::span<const NodePlace> nodes() const noexcept { return nodes_; }
  /// Number of triangles in the mesh that the root passes to its parent.
  uint32_t rootTriangles() const noexcept { return root_triangles_; }
  BuiltNode readRoot() const;

 private:
  friend class TreeletWriter;

  std::filesystem::path path_;
  uint64_t bytes_ = 0;
  std::vector<NodePlace> nodes_;
  RecordPlace root_;
  uint32_t root_triangles_ = 0;
};

/// Writes a treelet under a temporary name in the folder of the final path, and renames it when it is
/// complete. Several processes can write the same treelet at the same time. The destructor removes an
/// incomplete file. Not thread safe. All functions throw Error kIo.
class TreeletWriter {
 public:
  explicit TreeletWriter(std::filesystem::path path);

  /// Adds a node with the payloads of its LODs.
  void add(const Node& node, std::span<const std::vector<std::byte>> payloads);
  /// Number of nodes added so far.
  size_t nodes() const noexcept { return file_.nodes_.size(); }
  /// Completes and renames the file. @param root  the treelet's root, which add() has added.
  TreeletFile finish(const BuiltNode& root);

 private:
  RecordPlace append(std::span<const std::byte> bytes);

  TreeletFile file_;  ///< with the final path
  const std::filesystem::path temporary_path_;
  Spool spool_;
  RunningChecksum checksum_;
};

/// Returns the end of a temporary file's name, which no other process on any machine uses.
std::string temporaryEnding();

/// Reads records from treelets. Keeps the last file open, because neighbouring nodes often share a treelet.
/// Not thread safe. @throws Error kIo.
class TreeletReader {
 public:
  std::vector<std::byte> read(const std::filesystem::path& path, RecordPlace place);

 private:
  std::filesystem::path path_;
  std::optional<Spool> spool_;
};

}  // namespace lode::ingest
