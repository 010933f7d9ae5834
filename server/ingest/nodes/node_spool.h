#pragma once

#include <cstdint>
#include <mutex>
#include <string_view>
#include <vector>

#include "server/ingest/disk/spool.h"
#include "server/ingest/nodes/built_node_record.h"

namespace lode::ingest {

/// Finished nodes on their way to the store: on the disk, but for a key and a place each. Thread safe.
class NodeSpool {
 public:
  /// Name of the file.
  static constexpr std::string_view kFile = "nodes";

  explicit NodeSpool(TemporaryFile file) : spool_(std::move(file)) {}

  /// Makes room for the places of so many nodes.
  void reserve(size_t nodes) { places_.reserve(nodes); }
  size_t size() const noexcept { return places_.size(); }

  struct Place {
    NodeKey key;
    uint64_t offset = 0;
    uint32_t bytes = 0;
  };
  Place append(const Node& node, std::span<const PayloadSpool::Place> payloads);
  /// The record of a node, as putFinishedNode() wrote it.
  std::vector<std::byte> read(const Place& place);
  /// All nodes, in key order; the last call.
  std::vector<Place> takeSorted();

 private:
  std::mutex mutex_;
  Spool spool_;
  uint64_t flushed_ = 0;  ///< bytes that can be read
  std::vector<Place> places_;
};

}  // namespace lode::ingest
