#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "server/http/content_makers.h"
#include "server/http/listing.h"
#include "server/http/route.h"
#include "server/http/tileset.h"
#include "server/page/page_files.h"
#include "server/serve/ops/log.h"
#include "server/serve/session/catalog.h"

namespace lode::serve {

/// A content and how to make it.
struct HttpContent {
  std::string key;  ///< key in the cache
  std::string tag;  ///< base of the entity tag; any change of the content changes it
  http::ContentMakers::Make make;
};

/// Parts of the server that responses mention.
struct HttpSite {
  std::span<const page::PageFile> page;    ///< if empty, the server shows a list of the models instead
  std::optional<http::NativePort> native;  ///< the native port, if clients can connect to it directly
  bool is_native_local = true;             ///< only this machine reaches the native port
};

/// The contents that all HTTP connections of a server share. The key of a content names its source, so that
/// contents of unchanged models stay cached after a reload. Thread safe.
class HttpFiles {
 public:
  /// @param log  shared with threads that may outlive this object: see ContentMakers::join().
  HttpFiles(http::ContentMakersOptions options, std::shared_ptr<Log> log, const HttpSite& site);

  /// Returns the Tileset of a model.
  HttpContent tileset(std::shared_ptr<const Model> model) const;
  /// Returns a file of a model's tileset. @param file  name for which Tileset::has() returns true.
  HttpContent file(std::shared_ptr<const Model> model, std::shared_ptr<const http::Tileset> tileset,
                   const std::string& file) const;
  /// Returns the list of models as Resource::kIndex or kModels.
  /// @param grant  rights of the client; null allows all models. @param is_local  true if the request names
  /// this machine by a loopback name.
  HttpContent list(const Catalog& catalog, const TokenGrant* grant, http::Resource resource,
                   bool is_local) const;
  /// Returns the file of the page that a route names, or null.
  const page::PageFile* findPage(const http::Route& route) const noexcept;
  HttpContent page(const page::PageFile& file) const;

  /// Evicts the tilesets of models that are no longer served, because a cached tileset keeps its store open.
  void retain(const Catalog& catalog);
  http::ContentMakers& makers() noexcept { return makers_; }

 private:
  std::shared_ptr<Log> log_;
  HttpSite site_;
  http::ContentMakers makers_;
};

}  // namespace lode::serve
