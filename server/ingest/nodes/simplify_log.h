#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string_view>
#include <vector>

#include "server/ingest/disk/checkpoint_clock.h"
#include "server/ingest/nodes/built_node_record.h"
#include "server/ingest/nodes/node_builder.h"

namespace lode::ingest {

/// The nodes that a killed build had finished, as its journal tells. With a node, all below it are among
/// them, and its parent is, or its mesh is kept: the parent can be built.
struct FinishedNodes {
  struct Place {
    uint64_t offset = 0, bytes = 0, checksum = 0;
  };
  std::vector<FinishedNode> nodes;
  std::map<NodeKey, Place> roots;  ///< of finished subtrees: where what their parents need is kept
  uint64_t payload_bytes = 0;      ///< of the payloads' file
  uint64_t root_bytes = 0;         ///< of the roots' file

  /// Adds an entry that SimplifyLog wrote. @throws Error kFormat, kLimit.
  void add(RecordReader& record);
};

/// Notes finished nodes while a tree is simplified: an entry is collected, then written. For one thread, but
/// what is said to be thread safe.
class SimplifyLog {
 public:
  /// Name of the file with what parents need of the roots of finished subtrees; it lasts.
  static constexpr std::string_view kRootFile = "subtrees";
  using Append = std::function<void(std::span<const std::byte>)>;

  /// @param before  what a killed build had finished. @param append  puts an entry in the journal.
  SimplifyLog(const TemporaryFolder& folder, PayloadSpool& payloads, FinishedNodes before, Append append);

  /// What a killed build had finished; gone afterwards.
  std::vector<FinishedNode> takeFinished() { return std::move(before_.nodes); }
  /// Whether what its parent needs of a node was kept by a killed build. Thread safe, as the next one is.
  bool hasRoot(NodeKey key) const { return before_.roots.contains(key); }
  /// @throws Error kIo, kFormat.
  BuiltNode readRoot(NodeKey key) const;

  bool isDue() const noexcept { return clock_.isDue(CheckpointClock::Clock::now()); }
  /// @param record  of a finished node, as putFinishedNode() wrote it.
  void addFinished(std::span<const std::byte> record);
  /// A finished node whose parent is not finished and has not taken it yet.
  void addRoot(const BuiltNode& built);
  /// Returns when what was added since the last entry is on the disk.
  void write();

 private:
  PayloadSpool& payloads_;
  FinishedNodes before_;
  const Append append_;
  Spool roots_;
  CheckpointClock clock_;
  CheckpointClock::Clock::time_point began_{};  ///< of the entry that is being collected
  uint32_t finished_count_ = 0;
  RecordWriter finished_;
  std::vector<std::pair<NodeKey, FinishedNodes::Place>> new_roots_;
};

}  // namespace lode::ingest
