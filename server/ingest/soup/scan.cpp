#include "server/ingest/soup/scan.h"

#include <algorithm>
#include <filesystem>
#include <string>

#include "common/error.h"
#include "common/printable.h"

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

AttributeSet takenAttributes(AttributeSet attributes, const PlyCounts& counts) noexcept {
  if (counts.hasOnlyLengthlessNormals()) attributes.bits &= static_cast<uint8_t>(~AttributeSet::kNormal);
  return attributes;
}

namespace {

void checkVertices(const PlyHeader& header, const std::string& name) {
  const PlyElement* const vertices = header.find("vertex");
  if (vertices == nullptr || vertices->count <= UINT32_MAX) return;
  throw Error(ErrorCode::kLimit, name + ": " + std::to_string(vertices->count) +
                                     " vertices, more than 4294967295; split the model");
}

/// @param attributes  attributes to use from the file.
ScannedModel pack(PlyReader& reader, AttributeSet attributes, const TemporaryFolder& folder,
                  const BuildProgress& progress) {
  ScannedModel model{
      PackedInput(folder, attributes, hasDoublePositions(reader.header()), reader.faceAttributes()),
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
  return model;
}

ScannedModel packTaken(PlyReader& reader, const TemporaryFolder& folder, const BuildProgress& progress) {
  AttributeSet taken;
  {
    ScannedModel model = pack(reader, reader.attributes(), folder, progress);
    taken = takenAttributes(reader.attributes(), model.counts);
    if (taken == reader.attributes()) return model;
  }
  return pack(reader, taken, folder, progress);
}

std::vector<std::string> warningsOf(const PlyReader& reader, const PlyCounts& counts) {
  std::vector<std::string> warnings;
  const auto warn = [&](bool is_so, const std::string& words) {
    if (is_so) warnings.push_back(words);
  };
  const std::string skipped = skippedInWords(reader.skippedProperties(), reader.ignoresFaceColours());
  warn(!skipped.empty(), skipped);
  warn(counts.skipped_bad > 0,
       std::to_string(counts.skipped_bad) +
           " bad indices, coordinates or faces were skipped; lodestreamd doctor shows where");
  warn(counts.replaced_attributes > 0, replacedInWords(counts.replaced_attributes));
  warn(counts.unknown_textures > 0,
       unknownTexturesInWords(counts.unknown_textures, reader.header().texture_files.size()));
  warn(counts.lengthless_normals > 0, lengthlessInWords(counts));
  warn(counts.clamped_colours > 0, clampedInWords(counts.clamped_colours, reader.faceAttributes()));
  warn(counts.extra_tokens > 0,
       std::to_string(counts.extra_tokens) + " extra values at ends of lines were ignored");
  warn(counts.trailing_bytes > 0, trailingInWords(counts));
  return warnings;
}

void checkFaces(const PlyCounts& counts, const std::filesystem::path& name) {
  if (counts.triangles > 0) return;
  const std::string skipped =
      counts.skipped_bad > 0 ? ", with " + counted(counts.skipped_bad, "bad value") + " skipped" : "";
  throw Error(ErrorCode::kInput,
              name.string() + ": no usable face" + skipped + "; export the model again, with its faces");
}

}  // namespace

ScannedModel scan(const BuildOptions& options, const TemporaryFolder& folder, const BuildProgress& progress,
                  std::vector<std::string>& warnings) {
  const std::string name = options.input.string();
  PlyReader reader(options.input, {.skip_bad = options.skip_bad});
  checkVertices(reader.header(), name);
  ScannedModel model = packTaken(reader, folder, progress);
  checkFaces(model.counts, options.input);
  model.input.setUvGrid(chooseUvGrid(model.input.usedUvRange(), name));
  for (const std::string& warning : warningsOf(reader, model.counts))
    warnings.push_back(std::string(name).append(": ").append(warning));
  return model;
}

}  // namespace lode::ingest
