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

/// The input files of a model, and what they have in common.
struct Inputs {
  std::vector<PlyReader> readers;
  std::vector<std::string> names;  ///< paths for messages
  InputImages images;
  bool has_double_positions = false;

  const PlyReader& first() const noexcept { return readers.front(); }
};

Inputs openInputs(const BuildOptions& options) {
  const std::vector<std::filesystem::path> paths = inputsOf(options);
  Inputs inputs;
  uint64_t vertices = 0;
  for (const std::filesystem::path& path : paths) {
    const PlyReader& reader = inputs.readers.emplace_back(path, PlyReadOptions{.skip_bad = options.skip_bad});
    inputs.names.push_back(path.string());
    if (const PlyElement* const element = reader.header().find("vertex")) vertices += element->count;
    if (vertices > UINT32_MAX)
      throw Error(ErrorCode::kLimit, path.string() + ": " + std::to_string(vertices) +
                                         " vertices, more than 4294967295; split the model");
    if (reader.attributes() != inputs.first().attributes() ||
        reader.faceAttributes() != inputs.first().faceAttributes())
      throw Error(ErrorCode::kInput, path.string() + ": has other properties than " + inputs.names.front() +
                                         "; export all files with the same properties");
    inputs.has_double_positions |= hasDoublePositions(reader.header());
  }
  inputs.images = listImages(paths, options.textures_folder);
  return inputs;
}

/// Makes the faces of one of several files refer to the vertices and images of the whole model.
class FacesOfModel {
 public:
  /// @param images  numbers of the file's images in the model. @param has_textures  true if faces have
  /// texture coordinates, so that each face needs the number of its image.
  FacesOfModel(uint64_t first_vertex, std::span<const uint16_t> images, bool has_textures)
      : first_vertex_(first_vertex), images_(images), has_textures_(has_textures) {}

  const PlyFaces& renumbered(const PlyFaces& faces) {
    faces_ = faces;
    for (uint64_t& corner : faces_.corners) corner += first_vertex_;
    if (!has_textures_) return faces_;
    // In a file without numbers, all faces have the first image.
    if (faces_.materials.empty()) faces_.materials.resize(faces_.corner_counts.size());
    for (uint16_t& material : faces_.materials)
      material = material < images_.size() ? images_[material] : kNoMaterial;
    return faces_;
  }

 private:
  const uint64_t first_vertex_;
  const std::span<const uint16_t> images_;
  const bool has_textures_;
  PlyFaces faces_;
};

void add(PlyCounts& sum, const PlyCounts& counts) {
  sum.vertices += counts.vertices;
  sum.faces += counts.faces;
  sum.triangles += counts.triangles;
  sum.dropped_faces += counts.dropped_faces;
  sum.dropped_triangles += counts.dropped_triangles;
  sum.skipped_bad += counts.skipped_bad;
  sum.normals += counts.normals;
  sum.lengthless_normals += counts.lengthless_normals;
}

/// @param attributes  attributes to use from the files.
ScannedModel pack(Inputs& inputs, AttributeSet attributes, const TemporaryFolder& folder,
                  const BuildProgress& progress) {
  ScannedModel model{
      PackedInput(folder, attributes, inputs.has_double_positions, inputs.first().faceAttributes()),
      {},
      inputs.images.images};
  const size_t files = inputs.readers.size();
  for (size_t i = 0; i < files; ++i) {
    FacesOfModel of_model(model.input.vertexCount(), inputs.images.of_file[i],
                          attributes.has(AttributeSet::kTexture));
    const auto addFaces = [&](const PlyFaces& faces) {
      model.input.addFaces(files == 1 ? faces : of_model.renumbered(faces));
    };
    add(model.counts,
        inputs.readers[i].read(
            [&](uint64_t, std::span<const PlyVertex> vertices) { model.input.addVertices(vertices); },
            addFaces,
            [&](uint64_t done, uint64_t total) {
              const double part = total ? static_cast<double>(done) / static_cast<double>(total) : 1;
              if (progress)
                progress("scan", (static_cast<double>(i) + part) / static_cast<double>(files), done, total);
            }));
  }
  model.input.flush();
  return model;
}

ScannedModel packTaken(Inputs& inputs, const TemporaryFolder& folder, const BuildProgress& progress) {
  AttributeSet all = inputs.first().attributes();
  if (inputs.readers.size() > 1 && all.has(AttributeSet::kTexture)) all.bits |= AttributeSet::kMaterial;
  AttributeSet taken;
  {
    ScannedModel model = pack(inputs, all, folder, progress);
    taken = takenAttributes(all, model.counts);
    if (taken == all) return model;
  }
  return pack(inputs, taken, folder, progress);
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
  Inputs inputs = openInputs(options);
  ScannedModel model = packTaken(inputs, folder, progress);
  checkFaces(model.counts, options.input);
  model.input.setUvGrid(chooseUvGrid(model.input.usedUvRange(), inputs.names.front()));
  for (size_t i = 0; i < inputs.readers.size(); ++i)
    for (const std::string& warning : warningsOf(inputs.readers[i], inputs.readers[i].counts()))
      warnings.push_back(inputs.names[i] + ": " + warning);
  return model;
}

}  // namespace lode::ingest
