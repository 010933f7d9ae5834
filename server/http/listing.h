#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/codec/model_summary.h"

namespace lode::http {

/// Port of the native protocol, docs/protocol.md.
struct NativePort {
  uint16_t port = 0;
  bool has_tls = false;
};

/// Returns the content of /models.json: {"models": [{"name", "tileset", "build_id", "triangles", "nodes",
/// "bytes", "depth", "has_textures", "box", "size"}], "native": {"port", "tls"}}. The value of "tileset" is a
/// path relative to /models.json; "box" is [least, greatest] in the coordinates of the PLY file.
/// @param native  port that the reader can reach, or nothing. Thread safe.
std::string modelsJson(std::span<const ModelSummary> models, std::optional<NativePort> native);

/// Returns a self-contained HTML page with links to the models' tilesets, for a server that was built without
/// client/web. Thread safe.
std::string indexPage(std::span<const ModelSummary> models);

}  // namespace lode::http
