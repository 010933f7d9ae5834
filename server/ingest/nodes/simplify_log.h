#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string_view>
#include <vector>

#include "server/ingest/disk/journal.h"
#include "server/ingest/nodes/built_node_record.h"
#include "server/ingest/nodes/node_builder.h"

namespace lode::ingest {

/// The nodes that a killed build had finished, according to its journal. All nodes below a finished node are
/// finished too. The file SimplifyLog::kRootFile keeps the mesh of a finished node while the node's parent is
/// not finished, so that the parent can be built.
struct FinishedNodes {
  struct Place {
    uint64_t offset = 0, bytes = 0, checksum = 0;
  };
  std::vector<FinishedNode> nodes;
  /// For each root of a finished subtree, the place in the root file of the data that the root's parent
  /// needs.
  std::map<NodeKey, Place> roots;
  uint64_t payload_bytes = 0;  ///< size of the payload file
  uint64_t root_bytes = 0;     ///< size of the root file

  /// Adds an entry written by SimplifyLog. @throws Error kFormat, kLimit.
  void add(RecordReader& record);
};

/// Logs finished nodes in the build's journal during simplification: collects the content of an entry, then
/// writes the entry. Not thread safe, except the functions that are marked as thread safe.
class SimplifyLog {
 public:
  /// File with the data that parents of finished subtrees need; the file outlives a killed build.
  static constexpr std::string_view kRootFile = "subtrees";
  using Append = std::function<void(std::span<const std::byte>)>;

  /// @param before  nodes that a killed build had finished. @param append  function that adds an entry to the
  /// journal.
  SimplifyLog(const TemporaryFolder& folder, PayloadSpool& payloads, FinishedNodes before, Append append);

  /// Moves out the nodes that a killed build had finished.
  std::vector<FinishedNode> takeFinished() { return std::move(before_.nodes); }
  /// Returns true if a killed build kept the data that a node's parent needs. Thread safe.
  bool hasRoot(NodeKey key) const { return before_.roots.contains(key); }
  /// Reads the data that a killed build kept for a node's parent. Thread safe. @throws Error kIo, kFormat.
  BuiltNode readRoot(NodeKey key) const;

  bool isDue() const noexcept { return clock_.isDue(CheckpointClock::Clock::now()); }
  /// @param record  record of a finished node, as written by putFinishedNode().
  void addFinished(std::span<const std::byte> record);
  /// Adds a finished node whose parent is not built yet.
  void addRoot(const BuiltNode& built);
  /// Writes the entry. Returns when the entry and the data that it describes are on the disk.
  void write();

 private:
  PayloadSpool& payloads_;
  FinishedNodes before_;
  const Append append_;
  Spool roots_;
  CheckpointClock clock_;
  /// Time at which the first node was added to the current entry.
  CheckpointClock::Clock::time_point began_{};
  uint32_t finished_count_ = 0;
  RecordWriter finished_;
  std::vector<std::pair<NodeKey, FinishedNodes::Place>> new_roots_;
};

}  // namespace lode::ingest
