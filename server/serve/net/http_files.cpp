#include "server/serve/net/http_files.h"

#include <cstdio>
#include <set>
#include <span>
#include <utility>

#include "common/error.h"
#include "server/http/gzip.h"
#include "server/serve/memory/memory_reserve.h"

namespace lode::serve {

namespace {

constexpr std::string_view kTilesetKey = "tileset ";

/// Returns a key that identifies a model as long as the model exists. A Tileset keeps its model alive, so a
/// cached key never names another model.
std::string keyOf(const Model& model) {
  char key[32];
  std::snprintf(key, sizeof key, "%s%p", kTilesetKey.data(), static_cast<const void*>(&model));
  return key;
}

/// Removes the store's path from a message, because logs must not name folders.
std::string withoutPath(std::string message, const store::Reader& store) {
  const std::string path = store.path().string();
  if (const size_t at = message.find(path); at != std::string::npos)
    message.replace(at, path.size(), store.path().filename().string());
  return message;
}

/// Wraps a function so that its errors are logged, and so that it does not use the memory reserve.
http::ContentMakers::Make reporting(std::shared_ptr<Log> log, std::shared_ptr<const Model> model,
                                    http::ContentMakers::Make make) {
  return [log = std::move(log), model = std::move(model), make = std::move(make)] {
    const MemoryReserve::Abstention abstention;
    try {
      return make();
    } catch (const Error& error) {
      log->write(error.code() == ErrorCode::kIo ? LogKind::kUnreadableStore : LogKind::kDamagedStore,
                 "a tile of a model cannot be made",
                 {{"model", model->summary.name}, {"why", withoutPath(error.what(), model->blobs->store())}});
      throw;
    }
  };
}

/// Name of a file without folder and extension.
std::string stemOf(std::string_view file) {
  const size_t slash = file.find('/');
  if (slash != std::string_view::npos) file.remove_prefix(slash + 1);
  return std::string(file.substr(0, file.rfind('.')));
}

}  // namespace

HttpFiles::HttpFiles(http::ContentMakersOptions options, std::shared_ptr<Log> log, const HttpSite& site)
    : log_(std::move(log)), site_(site), makers_(options) {}

HttpContent HttpFiles::tileset(std::shared_ptr<const Model> model) const {
  std::string key = keyOf(*model);
  std::shared_ptr<const store::Reader> store(model, &model->blobs->store());
  return {std::move(key), {}, reporting(log_, std::move(model), [store = std::move(store)] {
            return std::make_unique<const http::Tileset>(store);
          })};
}

HttpContent HttpFiles::file(std::shared_ptr<const Model> model, std::shared_ptr<const http::Tileset> tileset,
                            const std::string& file) const {
  // All other names are derived from the files' contents, so that models can share cached files.
  const bool is_root = file == "tileset.json";
  std::string tag = is_root ? toHex(model->summary.build_id) : stemOf(file);
  std::string key = "file " + (is_root ? tag : file);
  return {std::move(key), std::move(tag),
          reporting(log_, std::move(model),
                    [tileset = std::move(tileset), file] { return tileset->make(file); })};
}

HttpContent HttpFiles::list(const Catalog& catalog, const TokenGrant* grant, http::Resource resource,
                            bool is_local) const {
  std::optional<http::NativePort> native = site_.native;
  if (site_.is_native_local && !is_local) native.reset();
  std::vector<ModelSummary> models;
  std::string values = resource == http::Resource::kIndex ? "page" : "json";
  if (native) values += " native";
  for (const auto& model : catalog.models()) {
    if (grant != nullptr && !grant->allows(model->summary.name)) continue;
    models.push_back(model->summary);
    values += '\n' + model->summary.name + ' ' + toHex(model->summary.build_id);
  }
  std::string tag = toHex(digestOf(std::as_bytes(std::span(values))));
  std::string key = "list " + tag;
  return {std::move(key), std::move(tag), [models = std::move(models), resource, native] {
            const std::string text = resource == http::Resource::kIndex ? http::indexPage(models)
                                                                        : http::modelsJson(models, native);
            const auto bytes = std::as_bytes(std::span(text));
            return std::make_unique<const http::FileContent>(
                std::vector<std::byte>(bytes.begin(), bytes.end()), http::gzip(bytes));
          }};
}

const page::PageFile* HttpFiles::findPage(const http::Route& route) const noexcept {
  const bool is_page =
      route.resource == http::Resource::kIndex || route.resource == http::Resource::kPageFile;
  return is_page ? page::findFile(site_.page, route.file) : nullptr;
}

HttpContent HttpFiles::page(const page::PageFile& file) const {
  return {"page " + std::string(file.name), std::string(file.hash), [bytes = file.bytes] {
            return std::make_unique<const http::FileContent>(bytes, http::gzip(bytes, http::kGzipMost));
          }};
}

void HttpFiles::retain(const Catalog& catalog) {
  std::set<std::string> served;
  for (const auto& model : catalog.models()) served.insert(keyOf(*model));
  makers_.cache().eraseIf(
      [&](const std::string& key) { return key.starts_with(kTilesetKey) && !served.contains(key); });
}

}  // namespace lode::serve
