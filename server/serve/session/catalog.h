#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/codec/model_summary.h"
#include "server/serve/session/blob_reader.h"
#include "server/serve/session/token_file.h"

namespace lode::serve {

class BlobReader;
struct ModelCounters;

/// A served model: its summary, the sizes of its blobs and their reader. Immutable except for the reader's
/// notes. Lives until no connection has it open.
struct Model {
  ModelSummary summary;
  std::vector<uint32_t> blob_bytes;         ///< by blob number; 0 if there is no such blob
  uint32_t coarsest_blob = 0;               ///< payload of the root's coarsest LOD; 0 without triangles
  std::shared_ptr<const BlobReader> blobs;  ///< null in tests of sessions, which read nothing

  uint32_t blobBytes(uint32_t number) const noexcept {
    return number < blob_bytes.size() ? blob_bytes[number] : 0;
  }
};

/// A model that a connection has opened.
struct OpenedModel {
  std::shared_ptr<const Model> model;
  Digest announced;                   ///< latest build that Opened or ModelReplaced announced to the client
  ModelCounters* counters = nullptr;  ///< null: count nothing
};

/// The models that a server serves, by name. Immutable; a reload replaces the whole catalog, and connections
/// keep the models that they have opened. Thread safe.
class Catalog {
 public:
  Catalog() = default;
  /// @throws Error kUsage (duplicate or invalid name), kLimit (more than a Models frame holds).
  explicit Catalog(std::vector<std::shared_ptr<const Model>> models);

  /// Returns the models sorted by name.
  std::span<const std::shared_ptr<const Model>> models() const noexcept { return models_; }
  /// Returns null if no model has that name.
  std::shared_ptr<const Model> find(std::string_view name) const noexcept;

 private:
  std::vector<std::shared_ptr<const Model>> models_;
};

/// Opens stores for a catalog.
/// @param stores  .lode files, and folders of .lode files.
/// @throws Error kUsage (no store, two models of one name), kIo, kFormat (a damaged store).
std::shared_ptr<const Catalog> openCatalog(std::span<const std::filesystem::path> stores,
                                           const BlobReaderOptions& options);

/// Opens the stores again for a reload. Unchanged stores stay open. A store that cannot be opened is
/// reported, and the model of its name in `before` stays. Folders may be empty.
/// @param refused  incremented for each store that cannot be opened; may be null.
/// @throws Error as openCatalog() does, also if a path in `stores` is gone that named no model in `before`,
/// such as a folder.
std::shared_ptr<const Catalog> reopenCatalog(const Catalog& before,
                                             std::span<const std::filesystem::path> stores,
                                             const BlobReaderOptions& options, size_t* refused = nullptr);

/// The models and the tokens of a server. A reload replaces both at once.
struct ServedSet {
  std::shared_ptr<const Catalog> catalog;
  std::shared_ptr<const TokenFile> tokens;  ///< null: clients need no token
};

}  // namespace lode::serve
