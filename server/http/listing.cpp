#include "server/http/listing.h"

#include <nlohmann/json.hpp>

#include "common/byte_size.h"
#include "common/printable.h"
#include "server/http/route.h"

namespace lode::http {

namespace {

using Json = nlohmann::ordered_json;

std::string tilesetPath(const ModelSummary& model) { return percentEncode(model.name) + "/tileset.json"; }

Json toJson(glm::dvec3 v) { return Json::array({v.x, v.y, v.z}); }

std::string escapeHtml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace

std::string modelsJson(std::span<const ModelSummary> models, std::optional<NativePort> native) {
  Json list = Json::array();
  for (const ModelSummary& model : models) {
    const glm::dvec3 least = model.lattice.toWorld(model.box.min);
    const glm::dvec3 greatest = model.lattice.toWorld(model.box.max);
    list.push_back({{"name", model.name},
                    {"tileset", tilesetPath(model)},
                    {"build_id", toHex(model.build_id)},
                    {"triangles", model.triangles},
                    {"nodes", model.nodes},
                    {"bytes", model.bytes},
                    {"depth", model.depth},
                    {"has_textures", static_cast<bool>(model.textures)},
                    {"box", Json::array({toJson(least), toJson(greatest)})},
                    {"size", toJson(greatest - least)}});
  }
  Json json{{"models", std::move(list)}};
  json["native"] = native ? Json{{"port", native->port}, {"tls", native->has_tls}} : Json();
  return json.dump();
}

std::string indexPage(std::span<const ModelSummary> models) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>Lodestream</title>\n"
      "<h1>Models</h1>\n<p>Each link is a tileset in the format 3D Tiles 1.1, for CesiumJS, three.js and "
      "other viewers.\n<ul>\n";
  for (const ModelSummary& model : models)
    page += "<li><a href=\"" + tilesetPath(model) + "\">" + escapeHtml(model.name) +
            "</a>: " + counted(model.triangles, "triangle") + ", " + describeBytes(model.bytes) + "\n";
  page += models.empty() ? "</ul>\n<p>This server has no model for you.\n</html>\n" : "</ul>\n</html>\n";
  return page;
}

}  // namespace lode::http
