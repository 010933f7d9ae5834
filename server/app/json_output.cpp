#include "server/app/json_output.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "common/error.h"

namespace lode::app {

void printText(const std::string& text, std::FILE* stream) {
  if (std::fwrite(text.data(), 1, text.size(), stream) == text.size() && std::fflush(stream) == 0) return;
  throw Error(ErrorCode::kIo, std::string("cannot write to standard output: ") + std::strerror(errno));
}

void printJson(const Json& object) {
  printText(object.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

Json toJson(const LatticeBox& box, const Lattice& lattice) {
  if (box.empty()) return nullptr;
  const glm::dvec3 min = lattice.toWorld(box.min), max = lattice.toWorld(box.max);
  return {{"min", {min.x, min.y, min.z}}, {"max", {max.x, max.y, max.z}}};
}

std::vector<std::string> attributeNames(AttributeSet attributes) {
  struct Name {
    uint8_t bit;
    const char* text;
  };
  constexpr std::array kNames{Name{AttributeSet::kNormal, "normal"}, Name{AttributeSet::kColour, "color"},
                              Name{AttributeSet::kAlpha, "alpha"}, Name{AttributeSet::kTexture, "uv"},
                              Name{AttributeSet::kMaterial, "texnumber"}};
  std::vector<std::string> names;
  for (const Name& name : kNames)
    if (attributes.has(name.bit)) names.emplace_back(name.text);
  return names;
}

Json toJson(const ModelSummary& summary) {
  const glm::dvec3 origin = summary.lattice.origin;
  Json json;
  json["name"] = summary.name;
  json["build_id"] = toHex(summary.build_id);
  json["triangles"] = summary.triangles;
  json["dropped"] = summary.dropped;
  json["nodes"] = summary.nodes;
  json["depth"] = summary.depth;
  json["payloads"] = summary.payloads;
  json["stored_triangles"] = summary.stored_triangles;
  json["triangles_per_node"] = summary.triangles_per_node;
  json["bytes"] = summary.bytes;
  json["box"] = toJson(summary.box, summary.lattice);
  json["origin"] = {origin.x, origin.y, origin.z};
  json["step"] = summary.lattice.step;
  json["attributes"] = attributeNames(summary.attributes);
  json["computed_normals"] = summary.attributes.has(AttributeSet::kComputedNormal);
  json["max_error"] = summary.max_error_model;
  return json;
}

double boxDiagonal(const ModelSummary& summary) {
  if (summary.box.empty()) return 0;
  return summary.lattice.step * glm::length(glm::dvec3(summary.box.max) - glm::dvec3(summary.box.min));
}

}  // namespace lode::app
