#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>
#include <vector>

#include "common/node_key.h"
#include "server/ingest/nodes/treelet_file.h"

namespace lode::ingest {

/// All nodes of a model, in finished treelets. Only add() is thread safe.
class BuiltTree {
 public:
  /// A node, its treelet, and the place of its record there.
  struct Place {
    NodeKey key;
    uint32_t treelet = 0;
    RecordPlace record;
  };

  /// Adds all nodes of a treelet.
  void add(const TreeletFile& file);
  size_t size() const noexcept { return places_.size(); }  ///< number of nodes
  uint64_t bytes() const noexcept { return bytes_; }       ///< size of the treelets' files
  /// Sorts the nodes by key and returns them.
  std::span<const Place> sorted();
  /// Reads a node. @throws Error kIo, kFormat.
  FinishedNode read(const Place& place);
  /// Reads a payload of a node. @throws Error kIo.
  std::vector<std::byte> readPayload(const Place& node, PayloadPlace payload);

 private:
  std::mutex mutex_;  ///< guards the next three members during add()
  uint64_t bytes_ = 0;
  std::vector<std::filesystem::path> treelets_;
  std::vector<Place> places_;
  TreeletReader reader_;
};

}  // namespace lode::ingest
