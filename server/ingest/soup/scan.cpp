#include "server/ingest/soup/scan.h"

#include <algorithm>
#include <filesystem>
#include <string>

#include "common/error.h"

namespace lode::ingest {

bool hasDoublePositions(const PlyHeader& header) {
  for (const PlyElement& element : header.elements) {
    if (element.name != "vertex") continue;
    return std::any_of(element.properties.begin(), element.properties.end(), [](const PlyProperty& property) {
      const bool is_position = property.name == "x" || property.name == "y" || property.name == "z";
      const bool is_exact_in_float = property.type == PlyType::kFloat32 || property.type == PlyType::kInt8 ||
                                     property.type == PlyType::kUint8 || property.type == PlyType::kInt16 ||
                                     property.type == PlyType::kUint16;
      return is_position && !is_exact_in_float;
    });
  }
  return false;
}

namespace {

void checkFaces(const PlyCounts& counts, const std::filesystem::path& name) {
  if (counts.triangles > 0) return;
  const std::string skipped = counts.skipped_bad > 0
                                  ? " is left without the " + std::to_string(counts.skipped_bad) + " bad ones"
                                  : "";
  throw Error(ErrorCode::kInput,
              name.string() + ": no usable face" + skipped + "; export the model again, with its faces");
}

}  // namespace

ScannedModel scan(const BuildOptions& options, const TemporaryFolder& folder, const BuildProgress& progress,
                  std::vector<std::string>& warnings) {
  PlyReader reader(options.input, {.skip_bad = options.skip_bad});
  for (const PlyElement& element : reader.header().elements) {
    if (element.name == "vertex" && element.count > UINT32_MAX) {
      throw Error(ErrorCode::kLimit, options.input.string() + ": " + std::to_string(element.count) +
                                         " vertices; at most 4294967295 can be indexed, split the model");
    }
  }
  ScannedModel model{PackedInput(folder, reader.attributes(), hasDoublePositions(reader.header()),
                                 reader.hasCornerTexture()),
                     {},
                     reader.header().texture_files};
  model.counts = reader.read(
      [&](uint64_t, std::span<const PlyVertex> vertices) { model.input.addVertices(vertices); },
      [&](const PlyFaces& faces) { model.input.addFaces(faces); },
      [&](uint64_t done, uint64_t total) {
        if (progress)
          progress("scan", total ? static_cast<double>(done) / static_cast<double>(total) : 1, done, total);
      });
  model.input.flush();
  checkFaces(model.counts, options.input);
  model.input.setUvGrid(chooseUvGrid(model.input.usedUvRange(), options.input.string()));
  const std::string skipped = skippedInWords(reader.skippedProperties());
  if (!skipped.empty()) warnings.push_back(options.input.string() + ": " + skipped);
  if (model.counts.skipped_bad > 0)
    warnings.push_back(options.input.string() + ": " + std::to_string(model.counts.skipped_bad) +
                       " bad indices, coordinates or faces were left out; lodestreamd doctor says where");
  if (model.counts.unknown_textures > 0)
    warnings.push_back(options.input.string() + ": " +
                       unknownTexturesInWords(model.counts.unknown_textures, model.texture_files.size()));
  if (model.counts.clamped_colours > 0)
    warnings.push_back(options.input.string() + ": " + clampedInWords(model.counts.clamped_colours));
  if (model.counts.extra_tokens > 0) {
    warnings.push_back(options.input.string() + ": " + std::to_string(model.counts.extra_tokens) +
                       " surplus values at the ends of lines were ignored");
  }
  return model;
}

}  // namespace lode::ingest
