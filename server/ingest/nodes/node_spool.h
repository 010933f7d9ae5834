#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "common/codec/hierarchy_page.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"
#include "server/ingest/mesh/node_mesh.h"

namespace lode::ingest {

/// LODs of a node on the disk, from when the simplifier has made them until they are measured: a large
/// node's would not fit beside either. For one thread. All functions throw Error kIo.
class LodSpool {
 public:
  explicit LodSpool(TemporaryFile file) : spool_(std::move(file)) {}

  void put(const SimplifiedMesh& lod);
  size_t size() const noexcept { return places_.size(); }
  /// Those that were put, by their order. @pre nothing is put after the first call.
  SimplifiedMesh read(size_t number);

 private:
  struct Place {
    uint64_t offset;
    AttributeSet attributes;
    size_t positions, wedges, wedge_attributes, triangles, remap;
    bool is_clustered;
  };

  Spool spool_;
  std::vector<Place> places_;
};

/// Encoded payloads on their way to the store. Thread safe.
class PayloadSpool {
 public:
  struct Place {
    uint64_t offset = 0;
    uint32_t bytes = 0;
  };
  /// Name of the file, which lasts.
  static constexpr std::string_view kFile = "payloads";

  explicit PayloadSpool(const TemporaryFolder& folder) : spool_(folder.lastingFile(kFile)) {}
  /// The first `bytes` that a killed build wrote; more is appended behind them. @throws Error kIo, kFormat.
  PayloadSpool(const TemporaryFolder& folder, uint64_t bytes) : spool_(folder.lastingFile(kFile), bytes) {}

  Place append(std::span<const std::byte> payload);
  void flush() { spool_.flush(); }
  /// Writes what was appended to the disk for good. @return its bytes.
  uint64_t sync();
  std::vector<std::byte> read(Place place) const;
  uint64_t size() const noexcept { return spool_.size(); }

 private:
  std::mutex mutex_;
  Spool spool_;
};

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
