#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/serve/session/blob_reader.h"
#include "server/serve/session/model.h"

namespace lode::serve {

/// What a server offers at one time: models by name. Immutable, and swapped whole at a reload; who has a
/// model open keeps it alive. Thread safe.
class Catalog {
 public:
  Catalog() = default;
  /// @throws Error kUsage (two of one name, a name that cannot be sent), kLimit (more than a list holds).
  explicit Catalog(std::vector<std::shared_ptr<const Model>> models);

  /// In the order of their names.
  std::span<const std::shared_ptr<const Model>> models() const noexcept { return models_; }
  /// @return null if there is none of that name.
  std::shared_ptr<const Model> find(std::string_view name) const noexcept;

 private:
  std::vector<std::shared_ptr<const Model>> models_;
};

/// Opens stores for a catalog.
/// @param stores  .lode files and folders of them.
/// @throws Error kUsage (no store, two models of one name), kIo, kFormat (a damaged store).
std::shared_ptr<const Catalog> openCatalog(std::span<const std::filesystem::path> stores,
                                           const BlobReaderOptions& options);

/// The same, again: stores that are as they were stay open, and one that cannot be opened keeps what there
/// was of its name and is reported. Folders may have lost all their stores.
/// @param refused  counts those that could not be opened; may be null. @throws Error as openCatalog()
/// where the list of stores is wrong, or what it names is gone of which there was nothing by that name: a
/// folder.
std::shared_ptr<const Catalog> reopenCatalog(const Catalog& before,
                                             std::span<const std::filesystem::path> stores,
                                             const BlobReaderOptions& options, size_t* refused = nullptr);

}  // namespace lode::serve
