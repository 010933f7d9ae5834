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

/// Stores the LODs of a large node on disk between simplification and measurement, because they do not fit
/// into memory beside the data of either step. Not thread safe. All functions throw Error kIo.
class LodSpool {
 public:
  explicit LodSpool(TemporaryFile file) : spool_(std::move(file)) {}

  void put(const SimplifiedMesh& lod);
  size_t size() const noexcept { return places_.size(); }
  /// Reads an LOD by its number in order of put(). @pre put() is not called after the first read().
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

/// Spool of encoded payloads until the store is written. Thread safe.
class PayloadSpool {
 public:
  struct Place {
    uint64_t offset = 0;
    uint32_t bytes = 0;
  };
  /// Name of the spool's file, which survives a killed build.
  static constexpr std::string_view kFile = "payloads";

  explicit PayloadSpool(const TemporaryFolder& folder) : spool_(folder.lastingFile(kFile)) {}
  /// Keeps the first `bytes` bytes of a killed build's file and appends after them. @throws Error kIo,
  /// kFormat.
  PayloadSpool(const TemporaryFolder& folder, uint64_t bytes) : spool_(folder.lastingFile(kFile), bytes) {}

  Place append(std::span<const std::byte> payload);
  void flush() { spool_.flush(); }
  /// Writes all appended bytes to the disk (fsync). @return the file's size.
  uint64_t sync();
  std::vector<std::byte> read(Place place) const;
  uint64_t size() const noexcept { return spool_.size(); }

 private:
  std::mutex mutex_;
  Spool spool_;
};

/// Spool of finished nodes until the store is written; keeps only a key and a place per node in memory.
/// Thread safe.
class NodeSpool {
 public:
  /// Name of the spool's file.
  static constexpr std::string_view kFile = "nodes";

  explicit NodeSpool(TemporaryFile file) : spool_(std::move(file)) {}

  /// Reserves memory for `nodes` places.
  void reserve(size_t nodes) { places_.reserve(nodes); }
  size_t size() const noexcept { return places_.size(); }

  struct Place {
    NodeKey key;
    uint64_t offset = 0;
    uint32_t bytes = 0;
  };
  Place append(const Node& node, std::span<const PayloadSpool::Place> payloads);
  /// Reads the record of a node that putFinishedNode() wrote.
  std::vector<std::byte> read(const Place& place);
  /// Returns all nodes in key order. Must be the last call.
  std::vector<Place> takeSorted();

 private:
  std::mutex mutex_;
  Spool spool_;
  uint64_t flushed_ = 0;  ///< number of bytes that can be read from the file
  std::vector<Place> places_;
};

}  // namespace lode::ingest
