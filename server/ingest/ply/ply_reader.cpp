#include "server/ingest/ply/ply_reader.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "common/error.h"
#include "common/printable.h"
#include "server/ingest/ply/ply_batch.h"
#include "server/ingest/ply/ply_body.h"
#include "server/ingest/ply/ply_input.h"
#include "server/ingest/ply/ply_plan.h"

namespace lode::ingest {
namespace {

/// Returns a message if the file is too short for the header's counts, else an empty string.
std::string sizeProblem(const PlyHeader& header, const PlyBody& body, const PlyInput& input) {
  uint64_t left = input.remaining() + 1;  // an ascii file may lack its last line end
  for (const PlyElement& element : header.elements) {
    const uint64_t row_bytes = body.leastRowBytes(element);
    if (row_bytes > 0 && element.count > left / row_bytes) {
      return input.name() + " is truncated: its header declares " + std::to_string(element.count) +
             " rows of " + quotedText(element.name) + " of " + std::to_string(row_bytes) +
             " bytes or more, but the body has only " + std::to_string(input.remaining()) +
             " bytes; copy or export the file again";
    }
    left -= element.count * row_bytes;
  }
  return {};
}

/// Counts the bytes after the last element.
uint64_t countTrailingBytes(PlyInput& input, PlyEncoding encoding) {
  if (encoding != PlyEncoding::kAscii) return input.remaining();
  for (; input.fill(1); input.consume(1)) {
    if (std::string_view(" \t\v\f\r\n").find(*input.data()) == std::string_view::npos) break;
  }
  return input.remaining();
}

class BodyWalk {
 public:
  BodyWalk(const PlyHeader& header, const PlyPlan& plan, PlyBody& body)
      : header_(header), plan_(plan), body_(body) {}

  void run(PlyVertexBatch& vertices, PlyFaceBatch& faces) {
    bool vertices_read = false;
    std::vector<std::pair<const FacePlan*, PlyPlace>> postponed;
    for (const PlyElement& element : header_.elements) {
      const FacePlan* face_plan = findFaces(element);
      if (&element == plan_.vertices.element) {
        body_.readVertices(plan_.vertices, vertices);
        vertices_read = true;
        readPostponed(postponed, faces);
      } else if (face_plan != nullptr && vertices_read) {
        body_.readFaces(*face_plan, faces);
      } else {
        if (face_plan != nullptr) postponed.emplace_back(face_plan, body_.place());
        body_.skip(element);
      }
    }
  }

 private:
  const FacePlan* findFaces(const PlyElement& element) const {
    const auto found = std::find_if(plan_.faces.begin(), plan_.faces.end(),
                                    [&](const FacePlan& plan) { return plan.element == &element; });
    return found == plan_.faces.end() ? nullptr : &*found;
  }

  /// Reads faces that precede the vertices in the file, then returns to the current place.
  void readPostponed(const std::vector<std::pair<const FacePlan*, PlyPlace>>& postponed,
                     PlyFaceBatch& faces) {
    if (postponed.empty()) return;
    const PlyPlace here = body_.place();
    for (const auto& [plan, place] : postponed) {
      body_.goTo(place);
      body_.readFaces(*plan, faces);
    }
    body_.goTo(here);
  }

  const PlyHeader& header_;
  const PlyPlan& plan_;
  PlyBody& body_;
};

}  // namespace

void PlyFaces::clear() {
  corner_counts.clear();
  corners.clear();
  texture.clear();
  materials.clear();
  colours.clear();
}

PlyReader::PlyReader(const std::filesystem::path& path, PlyReadOptions options)
    : path_(path), options_(options), header_(readPlyHeader(path)) {
  const PlyPlan plan = planBody(header_, quotedText(path.string(), 4096));
  attributes_ = plan.attributes();
  face_attributes_ = plan.faceAttributes();
  ignores_face_colours_ = plan.ignores_face_colours;
  skipped_properties_ = ingest::skippedProperties(header_, plan);
}

std::string skippedInWords(const std::vector<std::string>& skipped, bool ignores_face_colours) {
  constexpr size_t kShown = 12;
  if (skipped.empty()) return {};
  std::string words = "ignored properties: ";
  for (size_t i = 0; i < std::min(skipped.size(), kShown); ++i) words += (i == 0 ? "" : ", ") + skipped[i];
  if (skipped.size() > kShown) words += " and " + std::to_string(skipped.size() - kShown) + " more";
  if (ignores_face_colours) words += " (vertices have colours, too, and these are used)";
  return words;
}

std::string unknownTexturesInWords(uint64_t faces, size_t textures) {
  return counted(faces, "face") + " with a texnumber that is neither -1 nor below " +
         std::to_string(textures) +
         ", the number of textures in the header; they get no image; correct the texnumber or name the "
         "texture";
}

std::string lengthlessInWords(const PlyCounts& counts) {
  if (counts.lengthless_normals == 0) return {};
  const std::string all = std::to_string(counts.normals);
  if (counts.hasOnlyLengthlessNormals())
    return "none of its " + all + " normals has a length; the build computes normals";
  return std::to_string(counts.lengthless_normals) + " of " + all +
         (counts.lengthless_normals == 1 ? " normals has" : " normals have") +
         " no length; the build uses face normals there; if that is visible, remove all normals from the "
         "file, "
         "so that the build computes them";
}

std::string trailingInWords(const PlyCounts& counts) {
  return counted(counts.trailing_bytes, "byte") + " after the last element, from byte " +
         std::to_string(counts.trailing_from) + "; the build ignores them; check the counts in the header";
}

std::string replacedInWords(uint64_t rows) {
  return counted(rows, "vertex or face", "vertices or faces") +
         " with a NaN or infinite colour, normal or texture coordinate, set to 0; lodestreamd doctor shows "
         "where";
}

std::string clampedInWords(uint64_t rows, AttributeSet face_attributes) {
  return (face_attributes.has(AttributeSet::kColour) ? counted(rows, "face")
                                                     : counted(rows, "vertex", "vertices")) +
         " with colours outside the range of their type (float: 0 to 1, ushort: 0 to 65535, others: 0 to "
         "255), clamped; scale the values or declare the right type";
}

PlyCounts PlyReader::read(const VertexSink& vertices, const FaceSink& faces, const Progress& progress) {
  PlyInput input(path_);
  if (input.size() < header_.body_offset) {
    throw Error(ErrorCode::kIo, input.name() + " changed during reading; try again when it is complete");
  }
  input.seek(header_.body_offset);
  const PlyPlan plan = planBody(header_, input.name());
  PlyCounts& counts = counts_ = {};
  const std::unique_ptr<PlyBody> body =
      header_.encoding == PlyEncoding::kAscii
          ? makeAsciiBody(input, options_, header_.header_lines + 1, counts.extra_tokens)
          : makeBinaryBody(input, header_.encoding, options_);
  const std::string size_problem = sizeProblem(header_, *body, input);
  if (!size_problem.empty() && !options_.read_truncated) throw Error(ErrorCode::kInput, size_problem);

  const uint64_t total_bytes = input.remaining();
  uint64_t done_bytes = 0;
  const auto report = [&] {
    if (!progress) return;
    done_bytes = std::max(done_bytes, input.offset() - header_.body_offset);
    progress(done_bytes, total_bytes);
  };
  const VertexSink vertex_sink = [&](uint64_t first, std::span<const PlyVertex> rows) {
    if (vertices) vertices(first, rows);
    report();
  };
  const FaceSink face_sink = [&](const PlyFaces& batch) {
    if (faces && !batch.corner_counts.empty()) faces(batch);
    report();
  };
  SkippedVertices skipped;
  PlyVertexBatch vertex_batch(plan.vertices, vertex_sink, counts, skipped);
  PlyFaceBatch face_batch(plan, face_sink, counts, skipped);
  try {
    BodyWalk(header_, plan, *body).run(vertex_batch, face_batch);
  } catch (const Error& error) {
    vertex_batch.countRest();
    if (size_problem.empty() || error.code() != ErrorCode::kInput) throw;
  }
  if (!size_problem.empty()) throw Error(ErrorCode::kInput, size_problem);
  counts.trailing_bytes = countTrailingBytes(input, header_.encoding);
  counts.trailing_from = input.offset();
  if (progress) progress(total_bytes, total_bytes);
  return counts;
}

}  // namespace lode::ingest
