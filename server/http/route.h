#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lode::http {

enum class Resource : uint8_t {
  kIndex,        ///< "/", the page
  kPageFile,     ///< "/NAME", a file that the page loads
  kModels,       ///< "/models.json"
  kTileset,      ///< "/MODEL/tileset.json"
  kTilesetPage,  ///< "/MODEL/p/PAGE.json"
  kTile,         ///< "/MODEL/g/BLOB.V.glb"
  kJpeg,         ///< "/MODEL/i/IMAGE.V.jpg"
  kWebp,         ///< "/MODEL/i/IMAGE.V.webp"
  kWebSocket,    ///< "/ws"
  kUnknown,      ///< a path without a resource
  kMalformed,    ///< a target that is no path, or with an invalid percent-encoding
};

/// Returns true for files that gzip would not make smaller.
constexpr bool isBinary(Resource resource) noexcept {
  return resource == Resource::kTile || resource == Resource::kJpeg || resource == Resource::kWebp;
}

/// Resource that a request names.
struct Route {
  Resource resource = Resource::kUnknown;
  std::string model;  ///< for files of tilesets
  /// Name of a tileset's file as TileWriter gives it, such as "p/PAGE.json", or of a file of the page. Empty
  /// for resources without a file.
  std::string file;
  std::optional<std::string> token;  ///< token of a path "/t/TOKEN/..."
};

/// Finds the resource that a request's target names. A segment of the path is decoded after the path is
/// split, so an encoded slash never divides a path. Ignores the query. Names are only compared, never opened
/// as files. Thread safe.
Route parseTarget(std::string_view target);

/// Encodes a text as one segment of a path: every byte except letters, digits and "-._~" becomes %XX.
std::string percentEncode(std::string_view text);

/// Decodes %XX. @return nothing if a percent sign is not followed by two hexadecimal digits. The result can
/// contain any byte.
std::optional<std::string> percentDecode(std::string_view text);

}  // namespace lode::http
