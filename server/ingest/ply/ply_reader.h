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

/// A vertex as the file has it: true coordinates in double, attributes as written.
struct PlyVertex {
  glm::dvec3 position{0};
  glm::vec3 normal{0};
  glm::u8vec4 colour{255};
  glm::vec2 texture{0};
};

/// Faces as the file has them, flattened. Strips are cut into triangles already; polygons are not: they are
/// cut where positions are known (triangulate.h). Every face has at least 3 corners, none repeated.
struct PlyFaces {
  std::vector<uint32_t> corner_counts;  ///< one a face
  std::vector<uint64_t> corners;        ///< vertex numbers, all below the vertex element's count
  std::vector<glm::vec2> texture;   ///< one a corner, or empty where the file has no per-corner coordinates
  std::vector<uint16_t> materials;  ///< texnumber, one a face, or empty

  void clear();
};

struct PlyCounts {
  uint64_t vertices = 0;
  uint64_t faces = 0;                ///< rows of the face element, or strips
  uint64_t triangles = 0;            ///< sum of (corners - 2) over the faces given out
  uint64_t dropped_faces = 0;        ///< fewer than 3 corners, or a repeated index; of a strip, triangles
  uint64_t skipped_bad = 0;          ///< with skip_bad: faces and vertices that are left out
  uint64_t replaced_attributes = 0;  ///< with skip_bad: vertices that stay, with an attribute set to zero
  uint64_t dropped_triangles = 0;    ///< of the input, of both of these: with `triangles` they are all
  uint64_t clamped_colours = 0;      ///< vertices with a colour that its type has not, see clampedInWords()
  uint64_t normals = 0;              ///< where the file has them: of its vertices, but skipped ones
  uint64_t lengthless_normals = 0;   ///< of these, see hasDirection(); their vertices' are zero
  /// Faces with a texnumber that is neither -1 nor a texture's, where the header names some for coordinates.
  uint64_t unknown_textures = 0;
  uint64_t extra_tokens = 0;    ///< ascii only, ignored
  uint64_t trailing_bytes = 0;  ///< behind the last element, ignored (ascii: beyond blanks and line ends)

  uint64_t trailing_from = 0;  ///< byte of the file where these begin

  /// The file has normals, and none has a length.
  bool hasOnlyLengthlessNormals() const noexcept { return normals > 0 && lengthless_normals == normals; }
};

/// Something in the body that costs geometry.
struct PlyDefect {
  bool is_bad = false;  ///< skip_bad skips it, and without it reading fails; otherwise the face is none
  std::string text;     ///< element, number, byte or line, and what is wrong; no remedy
};

struct PlyReadOptions {
  /// Go on after a bad value: a vertex whose position is NaN or infinite is given out as all zero, to keep
  /// the numbers of those behind it, and no face that uses it is; an attribute that is NaN or infinite
  /// becomes zero; a face with an index out of range or with bad texture coordinates is left out. Each counts
  /// once, as replaced or as skipped.
  bool skip_bad = false;
  /// Read a file that is too short for what its header counts as far as it goes, and fail then.
  bool read_truncated = false;
  /// With skip_bad: is told each defect where it is found. Faces that use a skipped vertex are not among
  /// them.
  std::function<void(const PlyDefect&)> on_defect = {};
};

/// Streams the body of a PLY file in bounded memory; the counts of the header are never trusted with memory.
/// Vertices come first, then faces, each in batches in the file's order, whichever element the file has
/// first.
class PlyReader {
 public:
  /// @throws Error as readPlyHeader; kInput if there are no vertices or no faces.
  PlyReader(const std::filesystem::path& path, PlyReadOptions options);

  const PlyHeader& header() const noexcept { return header_; }
  /// Attributes found; normals as kNormal, alpha only if the file declares it.
  AttributeSet attributes() const noexcept { return attributes_; }
  /// Texture coordinates come with the faces' corners; those of vertices, if there are any, do not count.
  bool hasCornerTexture() const noexcept { return corner_texture_; }
  /// What the file has that is not read: see skippedProperties in ply_plan.h.
  const std::vector<std::string>& skippedProperties() const noexcept { return skipped_properties_; }

  using VertexSink = std::function<void(uint64_t first, std::span<const PlyVertex>)>;
  using FaceSink = std::function<void(const PlyFaces&)>;
  /// Fraction of the body read so far, in bytes.
  using Progress = std::function<void(uint64_t done_bytes, uint64_t total_bytes)>;

  /// May be called again: it starts anew.
  /// @throws Error kIo, kInput (element number and byte offset; in ascii the line).
  PlyCounts read(const VertexSink& vertices, const FaceSink& faces, const Progress& progress = {});
  /// Of the last read(); of one that failed, as far as it came.
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

/// "it has properties that are not read: ...", the first few of them, for warnings; empty if there are none.
std::string skippedInWords(const std::vector<std::string>& skipped);

/// "N faces with a texnumber ...", and what to do, for warnings.
std::string unknownTexturesInWords(uint64_t faces, size_t textures);

/// "N of M normals have no length ...", and what is done about it, for warnings; empty if all have one.
std::string lengthlessInWords(const PlyCounts& counts);

/// "N bytes behind the last element ...", and what to do, for warnings.
std::string trailingInWords(const PlyCounts& counts);

/// "N vertices with a colour, normal or ...", and what was done about it, for warnings.
std::string replacedInWords(uint64_t vertices);

/// "N vertices with colours ...", and what to do, for warnings.
std::string clampedInWords(uint64_t vertices);

}  // namespace lode::ingest
