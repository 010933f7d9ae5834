#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "common/mesh.h"
#include "server/ingest/ply/ply_header.h"

namespace lode::ingest {

/// A vertex of the file.
struct PlyVertex {
  glm::dvec3 position{0};
  glm::vec3 normal{0};
  glm::u8vec4 colour{255};
  glm::vec2 texture{0};
};

/// Faces of the file, flattened. Strips are cut into triangles; polygons are not, since that needs positions
/// (triangulate.h). Every face has at least 3 corners, none repeated.
struct PlyFaces {
  std::vector<uint32_t> corner_counts;  ///< one per face
  std::vector<uint64_t> corners;        ///< vertex numbers, all below the vertex element's count
  std::vector<glm::vec2> texture;       ///< one per corner; empty without per-corner coordinates
  std::vector<uint16_t> materials;      ///< texnumber, one per face, or empty

  void clear();
};

struct PlyCounts {
  uint64_t vertices = 0;
  uint64_t faces = 0;                ///< rows of the face element, or strips
  uint64_t triangles = 0;            ///< sum of (corners - 2) over accepted faces
  uint64_t dropped_faces = 0;        ///< with fewer than 3 corners or a repeated index; triangles of strips
  uint64_t skipped_bad = 0;          ///< with skip_bad: faces and vertices skipped
  uint64_t replaced_attributes = 0;  ///< with skip_bad: vertices with an attribute set to zero
  uint64_t dropped_triangles = 0;    ///< triangles of dropped and skipped faces
  uint64_t clamped_colours = 0;      ///< vertices with a colour out of range, see clampedInWords()
  uint64_t normals = 0;              ///< vertices with a normal, except skipped ones
  uint64_t lengthless_normals = 0;   ///< normals that fail hasDirection(); passed on as zero
  /// Faces whose texnumber is neither -1 nor that of a texture in the header, if the header names any.
  uint64_t unknown_textures = 0;
  uint64_t extra_tokens = 0;    ///< ascii: extra values in rows, ignored
  uint64_t trailing_bytes = 0;  ///< after the last element, ignored (ascii: after white space)

  uint64_t trailing_from = 0;  ///< file offset of the trailing bytes

  /// Returns whether the file has normals and none has a length.
  bool hasOnlyLengthlessNormals() const noexcept { return normals > 0 && lengthless_normals == normals; }
};

/// A defect in the body that loses geometry.
struct PlyDefect {
  bool is_bad = false;  ///< needs skip_bad, else reading fails; false: a degenerate face
  std::string text;     ///< element, row, byte or line, and problem, without remedy
};

struct PlyReadOptions {
  /// Continue after bad values. A vertex whose position is NaN or infinite becomes zero, which keeps the
  /// numbers of later vertices, and faces that use it are skipped. A NaN or infinite attribute becomes zero.
  /// A face with an index out of range or bad texture coordinates is skipped. Each counts once, as replaced
  /// or skipped.
  bool skip_bad = false;
  /// If the file is shorter than its header requires, read what exists before failing.
  bool read_truncated = false;
  /// With skip_bad: called for each defect, except for faces that use a skipped vertex.
  std::function<void(const PlyDefect&)> on_defect = {};
};

/// Streams the body of a PLY file in bounded memory; never allocates by the header's counts. Delivers
/// vertices, then faces, in batches in file order, whichever element is first in the file.
class PlyReader {
 public:
  /// @throws Error as readPlyHeader; kInput if there are no vertices or no faces.
  PlyReader(const std::filesystem::path& path, PlyReadOptions options);

  const PlyHeader& header() const noexcept { return header_; }
  /// Attributes of the file; alpha only if declared.
  AttributeSet attributes() const noexcept { return attributes_; }
  /// Returns whether faces have texture coordinates per corner; these override those of vertices.
  bool hasCornerTexture() const noexcept { return corner_texture_; }
  /// Properties that are not read: see skippedProperties() in ply_plan.h.
  const std::vector<std::string>& skippedProperties() const noexcept { return skipped_properties_; }

  using VertexSink = std::function<void(uint64_t first, std::span<const PlyVertex>)>;
  using FaceSink = std::function<void(const PlyFaces&)>;
  /// Reports the bytes of the body read so far.
  using Progress = std::function<void(uint64_t done_bytes, uint64_t total_bytes)>;

  /// Reads the whole body; every call starts at its beginning.
  /// @throws Error kIo, kInput (names the element and its byte offset or, in ascii, its line).
  PlyCounts read(const VertexSink& vertices, const FaceSink& faces, const Progress& progress = {});
  /// Counts of the last read(), even if it failed.
  const PlyCounts& counts() const noexcept { return counts_; }

 private:
  std::filesystem::path path_;
  PlyReadOptions options_;
  PlyHeader header_;
  AttributeSet attributes_;
  bool corner_texture_ = false;
  std::vector<std::string> skipped_properties_;
  PlyCounts counts_;
};

// Texts of warnings.

/// Lists the first few properties that are not read; empty if there are none.
std::string skippedInWords(const std::vector<std::string>& skipped);

std::string unknownTexturesInWords(uint64_t faces, size_t textures);

/// Empty if all normals have a length.
std::string lengthlessInWords(const PlyCounts& counts);
std::string trailingInWords(const PlyCounts& counts);
std::string replacedInWords(uint64_t vertices);
std::string clampedInWords(uint64_t vertices);

}  // namespace lode::ingest
