#pragma once

#include <span>
#include <string>

#include "common/codec/model_summary.h"

namespace lode::http {

/// Returns the content of /models.json: {"models": [{"name", "tileset", "build_id", "triangles", "nodes",
/// "bytes", "depth", "has_textures"}]}. The value of "tileset" is a path relative to /models.json.
/// Thread safe.
std::string modelsJson(std::span<const ModelSummary> models);

/// Returns the page "/" with links to the models' tilesets. The page is complete: it loads nothing.
/// Thread safe.
std::string indexPage(std::span<const ModelSummary> models);

}  // namespace lode::http
