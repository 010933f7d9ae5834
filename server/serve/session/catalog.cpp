#include "server/serve/session/catalog.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "common/error.h"
#include "common/limits.h"
#include "common/printable.h"
#include "proto/limits.h"
#include "proto/messages.h"

namespace lode::serve {

namespace {

namespace fs = std::filesystem;

constexpr const char* kNotServed = "the model is not served";

/// Returns true if both paths name one file, for example through a link or "./".
bool areTheSame(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return a == b || fs::equivalent(a, b, ignored);
}

/// Returns the store files. Replaces each folder with the stores in it.
/// @param allow_empty  if true, accepts folders without a store.
std::vector<fs::path> storeFiles(std::span<const fs::path> stores, bool allow_empty) {
  std::vector<fs::path> files;
  for (const fs::path& path : stores) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    const size_t before = files.size();
    for (fs::directory_iterator entry(path, error); !error && entry != fs::directory_iterator();
         entry.increment(error))
      if (entry->path().extension() == ".lode") files.push_back(entry->path());
    if (error) throw Error(ErrorCode::kIo, "cannot list " + path.string() + ": " + error.message());
    if (files.size() == before && !allow_empty)
      throw Error(ErrorCode::kUsage,
                  "no store (*.lode) in " + path.string() + "; make one with lodestreamd build");
  }
  std::ranges::sort(files);
  std::ranges::stable_sort(files, {}, [](const fs::path& file) { return file.stem().string(); });
  files.erase(std::unique(files.begin(), files.end(),
                          [](const fs::path& a, const fs::path& b) {
                            return a.stem() == b.stem() && areTheSame(a, b);
                          }),
              files.end());
  if (stores.empty())
    throw Error(ErrorCode::kUsage, "no store to serve; name a .lode file or a folder of .lode files");
  for (size_t i = 1; i < files.size(); ++i)
    if (files[i - 1].stem() == files[i].stem())
      throw Error(ErrorCode::kUsage, "two stores have the model name '" + files[i].stem().string() +
                                         "': " + files[i - 1].string() + " and " + files[i].string() +
                                         "; rename one");
  if (files.size() > proto::kMaxListedModels)
    throw Error(ErrorCode::kLimit, std::to_string(files.size()) +
                                       " stores are too many for one server; the limit is " +
                                       std::to_string(proto::kMaxListedModels));
  return files;
}

std::shared_ptr<const Model> openModel(const fs::path& file, const BlobReaderOptions& options) {
  const std::string name = file.stem().string();
  if (name.empty() || name.size() > kMaxModelNameBytes || !isPrintableUtf8(name))
    throw Error(ErrorCode::kUsage, "the name of " + file.string() + " cannot name a model: use at most " +
                                       std::to_string(kMaxModelNameBytes) + " bytes of printable UTF-8");
  store::Reader reader(file);
  auto model = std::make_shared<Model>();
  model->summary = reader.summary();
  model->summary.name = name;
  const uint32_t blobs = reader.blobCount();
  model->blob_bytes.resize(size_t{blobs} + 1);
  for (uint32_t number = 1; number <= blobs; ++number) model->blob_bytes[number] = reader.blob(number).bytes;
  if (const Node* root = reader.find(kRootKey); root != nullptr && !root->lods.empty())
    model->coarsest_blob = root->lods.back().payload.number;
  model->blobs = std::make_shared<const BlobReader>(std::move(reader), options);
  return model;
}

/// Replaces the path with the file name, because logs must not name folders.
std::string withoutFolder(std::string message, const fs::path& file) {
  const std::string path = file.string();
  if (const size_t at = message.find(path); at != std::string::npos)
    message.replace(at, path.size(), file.filename().string());
  return message;
}

/// Reports that a store cannot be opened and adds the store to `skipped`. @param then  consequence, for the
/// report.
void skip(const fs::path& file, const Error& error, const char* then, const BlobReaderOptions& options,
          std::vector<SkippedStore>& skipped) {
  SkippedStore store{file.stem().string(), withoutFolder(error.what(), file)};
  options.report(error.code() == ErrorCode::kIo ? StoreFault::kUnreadable : StoreFault::kDamaged,
                 "the store of model '" + store.model + "' cannot be opened; " + then + ": " + store.why);
  skipped.push_back(std::move(store));
}

bool isUnchanged(const Model& model, const fs::path& file) {
  struct stat now {};
  return model.blobs && ::stat(file.c_str(), &now) == 0 && model.blobs->isStill(now);
}

}  // namespace

Catalog::Catalog(std::vector<std::shared_ptr<const Model>> models) : models_(std::move(models)) {
  std::ranges::sort(models_, {}, [](const auto& model) { return model->summary.name; });
  proto::Models list;
  for (const auto& model : models_) list.models.push_back(model->summary);
  try {
    proto::encode(list, 0);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kLimit) throw;
    throw Error(
        ErrorCode::kLimit,
        "the names of " + std::to_string(models_.size()) +
            " models do not fit into one frame; shorten them, or serve some stores from another server");
  }
}

std::shared_ptr<const Model> Catalog::find(std::string_view name) const noexcept {
  const auto found = std::ranges::lower_bound(
      models_, name, {}, [](const auto& model) { return std::string_view(model->summary.name); });
  return found != models_.end() && (*found)->summary.name == name ? *found : nullptr;
}

std::shared_ptr<const Catalog> openCatalog(std::span<const fs::path> stores, const BlobReaderOptions& options,
                                           std::vector<SkippedStore>* skipped) {
  std::vector<std::shared_ptr<const Model>> models;
  std::optional<Error> first;
  for (const fs::path& file : storeFiles(stores, false)) try {
      models.push_back(openModel(file, options));
    } catch (const Error& error) {
      if (skipped == nullptr || std::ranges::find(stores, file) != stores.end()) throw;
      if (!first) first = error;
      skip(file, error, kNotServed, options, *skipped);
    }
  if (models.empty() && first) throw Error(*first);
  return std::make_shared<const Catalog>(std::move(models));
}

std::shared_ptr<const Catalog> reopenCatalog(const Catalog& before, std::span<const fs::path> stores,
                                             const BlobReaderOptions& options,
                                             std::vector<SkippedStore>& skipped) {
  std::vector<std::shared_ptr<const Model>> models;
  for (const fs::path& file : storeFiles(stores, true)) {
    std::shared_ptr<const Model> model = before.find(file.stem().string());
    if (!model || !isUnchanged(*model, file)) try {
        model = openModel(file, options);
      } catch (const Error& error) {
        // Fail if the command line names this path, for example a missing folder.
        if (!model && std::ranges::find(stores, file) != stores.end()) throw;
        skip(file, error, model ? "its previous build stays" : kNotServed, options, skipped);
      }
    if (model) models.push_back(std::move(model));
  }
  return std::make_shared<const Catalog>(std::move(models));
}

}  // namespace lode::serve
