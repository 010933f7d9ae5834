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

/// Faces of the file, as flat arrays. The reader cuts strips into triangles, but leaves polygons whole,
/// because triangulate() needs positions to cut them. Every face has at least 3 corners, all at different
/// vertices.
struct PlyFaces {
  std::vector<uint32_t> corner_counts;    ///< number of corners of each face
  std::vector<uint64_t> corners;          ///< vertex indices, all smaller than the vertex element's count
  std::vector<glm::vec2> texture;         ///< texture coordinates of each corner, or empty
  std::vector<uint16_t> materials;        ///< texnumber of each face, or empty
  std::vector<glm::u8vec4> colours = {};  ///< colour of each face, or empty

  void clear();
};

struct PlyCounts {
  uint64_t vertices = 0;
  uint64_t faces = 0;      ///< rows of the face element, and strips
  uint64_t triangles = 0;  ///< sum of (corners - 2) over accepted faces
  /// Faces with fewer than 3 corners or a repeated index; in strips, triangles with a repeated index.
  uint64_t dropped_faces = 0;
  uint64_t skipped_bad = 0;  ///< faces and vertices skipped because skip_bad is set
  /// Vertices with an attribute, and faces with a colour, that became zero because skip_bad is set.
  uint64_t replaced_attributes = 0;
  uint64_t dropped_triangles = 0;   ///< triangles of dropped and skipped faces
  uint64_t clamped_colours = 0;     ///< vertices or faces with a colour out of range, see clampedInWords()
  uint64_t normals = 0;             ///< normals of vertices that are not skipped
  uint64_t lengthless_normals = 0;  ///< number of these normals that fail hasDirection()
  /// Faces with a texnumber that is neither -1 nor the index of a texture in the header. 0 if the header
  /// names no texture.
  uint64_t unknown_textures = 0;
  uint64_t extra_tokens = 0;  ///< ignored values that follow the properties of ascii rows
  /// Ignored bytes after the last element; in ascii files, white space does not count.
  uint64_t trailing_bytes = 0;

  uint64_t trailing_from = 0;  ///< file offset of the trailing bytes

  /// Returns true if the file has normals, but all have length zero.
  bool hasOnlyLengthlessNormals() const noexcept { return normals > 0 && lengthless_normals == normals; }
};

/// A defect in the body, reported to PlyReadOptions::on_defect.
struct PlyDefect {
  bool is_bad = false;  ///< true if reading fails unless skip_bad is set; false for a degenerate face
  std::string text;     ///< element, row, byte or line, and the problem, without a remedy
  uint64_t rows = 1;    ///< number of rows with this problem, counted from the reported row on
};

struct PlyReadOptions {
  /// If set, the reader continues after bad values. If an attribute of a vertex or a colour of a face is NaN
  /// or infinite, it becomes zero. A vertex whose position is NaN or infinite becomes zero too, so that later
  /// vertices keep their indices; faces that use this vertex are skipped. Faces with an index out of range or
  /// with bad texture coordinates are also skipped. Each vertex or face counts once, as replaced or as
  /// skipped.
  bool skip_bad = false;
  /// If set and the file is shorter than its header requires, the reader reads all existing rows before it
  /// fails.
  bool read_truncated = false;
  /// Receives degenerate faces and, if skip_bad is set, bad values. Does not receive faces that are skipped
  /// because they use a skipped vertex.
  std::function<void(const PlyDefect&)> on_defect = {};
};

/// Streams the body of a PLY file. Its memory use does not depend on the counts in the header. Passes all
/// vertices and then all faces to the sinks, in batches and in file order, even if the faces come first in
/// the file.
class PlyReader {
 public:
  /// Opens a file and reads its header. @throws Error as readPlyHeader() does; kInput also if the file has no
  /// vertices or no faces.
  PlyReader(const std::filesystem::path& path, PlyReadOptions options);

  const PlyHeader& header() const noexcept { return header_; }
  /// Returns the attributes of the file, with alpha only if the header declares it.
  AttributeSet attributes() const noexcept { return attributes_; }
  /// Returns the attributes that are stored per face or per corner instead of per vertex. Texture coordinates
  /// of corners override those of vertices; colours of vertices override those of faces.
  AttributeSet faceAttributes() const noexcept { return face_attributes_; }
  /// Returns true if the reader skips the colours of faces because vertices have colours, too.
  bool ignoresFaceColours() const noexcept { return ignores_face_colours_; }
  /// Returns the properties that the reader skips; see skippedProperties() in ply_plan.h.
  const std::vector<std::string>& skippedProperties() const noexcept { return skipped_properties_; }

  using VertexSink = std::function<void(uint64_t first, std::span<const PlyVertex>)>;
  using FaceSink = std::function<void(const PlyFaces&)>;
  /// Reports the bytes of the body read so far.
  using Progress = std::function<void(uint64_t done_bytes, uint64_t total_bytes)>;

  /// Reads the whole body. Every call starts at the beginning of the body.
  /// @throws Error kIo, kInput (the message names the element and the byte offset or, in ascii, the line).
  PlyCounts read(const VertexSink& vertices, const FaceSink& faces, const Progress& progress = {});
  /// Returns the counts of the last read(), even if that call failed.
  const PlyCounts& counts() const noexcept { return counts_; }

 private:
  std::filesystem::path path_;
  PlyReadOptions options_;
  PlyHeader header_;
  AttributeSet attributes_;
  AttributeSet face_attributes_;
  bool ignores_face_colours_ = false;
  std::vector<std::string> skipped_properties_;
  PlyCounts counts_;
};

// Functions that return the text of a warning.

/// Lists the first few skipped properties. Returns an empty string if the reader reads all properties.
/// @param ignores_face_colours  see PlyReader::ignoresFaceColours().
std::string skippedInWords(const std::vector<std::string>& skipped, bool ignores_face_colours = false);

std::string unknownTexturesInWords(uint64_t faces, size_t textures);

/// Returns a warning about normals of length zero, or an empty string if all normals have a length.
std::string lengthlessInWords(const PlyCounts& counts);
std::string trailingInWords(const PlyCounts& counts);
std::string replacedInWords(uint64_t rows);
/// @param face_attributes  see PlyReader::faceAttributes().
std::string clampedInWords(uint64_t rows, AttributeSet face_attributes);

}  // namespace lode::ingest
