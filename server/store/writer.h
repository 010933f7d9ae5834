#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "common/atomic_file.h"
#include "common/hierarchy_page.h"
#include "common/model_summary.h"

namespace lode::store {

/// Writes one store. The caller adds payloads in the order in which they shall lie in the file (coarse first,
/// siblings together), then finishes with the nodes; pages, blob table, index and header are written then,
/// and the file appears under its name. Not thread safe.
class Writer {
 public:
  explicit Writer(const std::filesystem::path& path);

  /// Equal bytes give the same blob. @throws Error kIo, kLimit.
  BlobRef addBlob(std::span<const std::byte> bytes);

  /// @param summary  lattice, box, attributes, triangles, dropped, triangles_per_node are read from it; the
  /// rest is
  ///                 counted here.
  /// @param nodes    all nodes in key order, without child pages; they are filled in.
  /// @return the summary as a reader will see it. @throws Error kIo, kFormat.
  ModelSummary finish(ModelSummary summary, std::vector<Node> nodes);

 private:
  AtomicFile file_;
  std::filesystem::path path_;
  struct Entry;
  std::vector<Entry> entries_;
};

}  // namespace lode::store
