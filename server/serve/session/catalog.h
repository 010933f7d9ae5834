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

/// A served model: its summary, the sizes of its blobs, and the reader of the blobs. Immutable, except that
/// the reader records the verified blobs. A replaced model exists until the last connection closes it.
struct Model {
  ModelSummary summary;
  /// Size of each blob, indexed by the blob's number; 0 if there is no blob with this number.
  std::vector<uint32_t> blob_bytes;
  /// Number of the root's coarsest payload; 0 if the model has no triangles.
  uint32_t coarsest_blob = 0;
  std::shared_ptr<const BlobReader> blobs;  ///< null in tests of sessions, which read no blobs

  uint32_t blobBytes(uint32_t number) const noexcept {
    return number < blob_bytes.size() ? blob_bytes[number] : 0;
  }
};

/// A model that a connection has opened.
struct OpenedModel {
  std::shared_ptr<const Model> model;
  Digest announced;                   ///< latest build that Opened or ModelReplaced announced to the client
  ModelCounters* counters = nullptr;  ///< counters of the model, or null to count nothing
};

/// The models that a server serves, by name. Immutable; a reload replaces the whole catalog, and connections
/// keep the models that they have opened. Thread safe.
class Catalog {
 public:
  Catalog() = default;
  /// @throws Error kUsage (duplicate or invalid name), kLimit (more models than fit in a Models frame).
  explicit Catalog(std::vector<std::shared_ptr<const Model>> models);

  /// Returns the models sorted by name.
  std::span<const std::shared_ptr<const Model>> models() const noexcept { return models_; }
  /// Returns the model with this name, or null.
  std::shared_ptr<const Model> find(std::string_view name) const noexcept;

 private:
  std::vector<std::shared_ptr<const Model>> models_;
};

/// A store that a catalog skips because it cannot be opened.
struct SkippedStore {
  std::string model;  ///< name of the model; after a reload its previous build can still be served
  std::string why;    ///< reason, without names of folders
};

/// Opens stores for a catalog.
/// @param stores   .lode files, and folders of .lode files.
/// @param skipped  receives each store in a folder that cannot be opened; the store is also reported. If
/// null, such a store is an error.
/// @throws Error kUsage (no store, two models of one name), kIo, kFormat (a damaged store) if a file in
/// `stores` or every store cannot be opened.
std::shared_ptr<const Catalog> openCatalog(std::span<const std::filesystem::path> stores,
                                           const BlobReaderOptions& options,
                                           std::vector<SkippedStore>* skipped = nullptr);

/// Opens the stores again for a reload. Unchanged stores stay open. If a store cannot be opened, reports the
/// error and keeps the model with the same name in `before`, if any. Folders may be empty.
/// @param skipped  receives the stores that cannot be opened.
/// @throws the errors of openCatalog(), and Error kIo if a path in `stores` is missing and belongs to no
/// model in `before`, such as a folder.
std::shared_ptr<const Catalog> reopenCatalog(const Catalog& before,
                                             std::span<const std::filesystem::path> stores,
                                             const BlobReaderOptions& options,
                                             std::vector<SkippedStore>& skipped);

/// The models and the tokens of a server. A reload replaces models and tokens in a single step.
struct ServedSet {
  std::shared_ptr<const Catalog> catalog;
  std::shared_ptr<const TokenFile> tokens;  ///< tokens of the clients; null: clients need no token
};

}  // namespace lode::serve
