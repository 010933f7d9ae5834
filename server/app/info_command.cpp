#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <vector>

#include "common/byte_size.h"
#include "server/app/command.h"
#include "server/app/json_output.h"
#include "server/store/node_tree.h"
#include "server/store/reader.h"

namespace lode::app {
namespace {

struct InfoArguments {
  std::filesystem::path store;
  bool json = false, nodes = false;
};

uint64_t countLods(const store::Reader& reader) {
  uint64_t lods = 0;
  for (const Node& node : reader.nodes()) lods += node.lods.size();
  return lods;
}

/// The largest input of the nodes of one depth: the triangles of their children from which LODs are made.
struct LargestInput {
  uint32_t depth = 0, nodes = 0;
  uint64_t triangles = 0;
};

/// Depths whose inputs describe() prints. Inputs grow towards the root, because nodes lock their borders.
constexpr int kDepthsNearRoot = 3;

std::vector<LargestInput> inputsNearRoot(const store::Reader& reader) {
  std::vector<LargestInput> inputs;
  for (const Node& node : reader.nodes()) {
    const auto depth = static_cast<uint32_t>(node.key.depth());
    if (depth >= kDepthsNearRoot) break;  // nodes are in key order
    if (node.isLeaf()) continue;
    uint64_t triangles = 0;
    for (unsigned octant = 0; octant < 8; ++octant)
      if (node.child_mask >> octant & 1)
        triangles += reader.find(node.key.child(octant))->sourceLod().triangles;
    if (inputs.empty() || inputs.back().depth != depth) inputs.push_back({.depth = depth});
    ++inputs.back().nodes;
    inputs.back().triangles = std::max(inputs.back().triangles, triangles);
  }
  return inputs;
}

uint64_t bytesOf(const Texture& texture) {
  uint64_t bytes = 0;
  for (const BlobRef& tile : texture.tiles) bytes += tile.bytes;
  return bytes;
}

Json textureAsJson(const Texture& texture) {
  return {{"name", texture.name},          {"width", texture.width},        {"height", texture.height},
          {"levels", levelCount(texture)}, {"tiles", texture.tiles.size()}, {"bytes", bytesOf(texture)}};
}

std::string describe(const Texture& texture) {
  if (texture.tiles.empty()) return texture.name + ", missing";
  return texture.name + ", " + std::to_string(texture.width) + " x " + std::to_string(texture.height) + ", " +
         std::to_string(texture.tiles.size()) + " tiles, " + describeBytes(bytesOf(texture));
}

std::string describe(const store::Reader& reader, uint64_t lods) {
  const ModelSummary& summary = reader.summary();
  const Json json = toJson(summary);
  std::string attributes;
  for (const std::string& name : attributeNames(summary.attributes))
    attributes += (attributes.empty() ? "" : ", ") + name;
  if (summary.attributes.has(AttributeSet::kComputedNormal)) attributes += " (normals computed)";
  std::string text;
  const auto line = [&](const char* name, const std::string& value) {
    std::string start(name);
    start.resize(18, ' ');
    text += start + value + "\n";
  };
  line("model", summary.name);
  line("build id", toHex(summary.build_id));
  line("triangles", std::to_string(summary.triangles) + ", dropped " + std::to_string(summary.dropped));
  line("stored triangles", std::to_string(summary.stored_triangles));
  line("nodes", std::to_string(summary.nodes) + ", depth " + std::to_string(summary.depth));
  line("lods", std::to_string(lods) + ", payloads " + std::to_string(summary.payloads));
  line("bytes", std::to_string(summary.bytes));
  line("box", json["box"].dump());
  line("origin", json["origin"].dump());
  line("step", json["step"].dump());
  line("attributes", attributes.empty() ? "none" : attributes);
  line("max error", json["max_error"].dump());
  for (const LargestInput& input : inputsNearRoot(reader)) {
    char budgets[32];
    std::snprintf(budgets, sizeof budgets, "%.1f",
                  static_cast<double>(input.triangles) / summary.triangles_per_node);
    line("input of depth", std::to_string(input.depth) + ": at most " + std::to_string(input.triangles) +
                               " triangles a node, " + budgets + " times its capacity");
  }
  for (const Texture& texture : reader.textures().textures) line("texture", describe(texture));
  return text;
}

Json lodAsJson(const Node& node, size_t number, const Lattice& lattice) {
  const Lod& lod = node.lods[number];
  return {{"key", node.key.value},
          {"depth", node.key.depth()},
          {"lod", number},
          {"leaf", node.isLeaf()},
          {"triangles", lod.triangles},
          {"locked", lod.locked},
          {"bytes", lod.payload.bytes},
          {"error", lod.error_model},
          {"appearance_error", lod.appearance_error_model},
          {"far", number + node.far_lods >= node.lods.size()},
          {"box", toJson(node.box, lattice)}};
}

/// Headings of the columns that describe(node, LOD) prints.
constexpr const char* kLodColumns =
    "depth LOD  triangles   locked      bytes        error   appearance  node";

std::string describe(const Node& node, size_t number) {
  const Lod& lod = node.lods[number];
  std::array<char, 160> numbers{};
  std::snprintf(numbers.data(), numbers.size(), "%5u %4zu %10u %8u %10u %12g %12g  ", node.key.depth(),
                number, lod.triangles, lod.locked, lod.payload.bytes, lod.error_model,
                lod.appearance_error_model);
  return numbers.data() + store::describeKey(node.key) + (node.isLeaf() ? " (leaf)" : "");
}

/// Prints a line for each LOD of each node, in the order of node keys.
void printNodes(const store::Reader& reader, bool as_json) {
  if (!as_json) printText(std::string(kLodColumns) + "\n");
  for (const Node& node : reader.nodes())
    for (size_t number = 0; number < node.lods.size(); ++number)
      if (as_json)
        printJson(lodAsJson(node, number, reader.summary().lattice));
      else
        printText(describe(node, number) + "\n");
}

void runInfo(const InfoArguments& arguments) {
  const store::Reader reader(arguments.store);
  if (arguments.nodes) return printNodes(reader, arguments.json);
  const uint64_t lods = countLods(reader);
  if (!arguments.json) return printText(describe(reader, lods));
  Json json = toJson(reader.summary());
  json["lods"] = lods;
  json["largest_inputs"] = Json::array();
  for (const LargestInput& input : inputsNearRoot(reader))
    json["largest_inputs"].push_back(
        {{"depth", input.depth}, {"nodes", input.nodes}, {"triangles", input.triangles}});
  json["textures"] = Json::array();
  for (const Texture& texture : reader.textures().textures)
    json["textures"].push_back(textureAsJson(texture));
  printJson(json);
}

}  // namespace

void addInfoCommand(CLI::App& program) {
  const auto arguments = std::make_shared<InfoArguments>();
  CLI::App* command = addCommand(program, "info", "Describe a store");
  command->add_option("store", arguments->store, "the store")->required()->type_name("STORE");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->add_flag("--nodes", arguments->nodes,
                    "print a line for each LOD of each node; with --json a JSON object");
  command->callback([arguments] { runInfo(*arguments); });
}

}  // namespace lode::app
