#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "server/ingest/ply/ply_plan.h"
#include "server/ingest/ply/ply_reader.h"

namespace lode::ingest {

constexpr size_t kPlyBatchRows = 8192;
/// Maximum number of corners of a face. The time of ear clipping can grow with the square of the number of
/// corners.
constexpr uint64_t kMaxFaceCorners = 1u << 16;

/// Set of skipped vertices. An empty set takes no memory; any other set takes at most about one bit per
/// vertex of the file.
class SkippedVertices {
 public:
  void add(uint64_t vertex);
  bool any() const noexcept { return !pages_.empty(); }
  bool contains(uint64_t vertex) const noexcept;

 private:
  static constexpr uint64_t kPageBits = 1u << 16;
  using Page = std::array<uint64_t, kPageBits / 64>;
  std::vector<std::unique_ptr<Page>> pages_;
};

/// Collects vertices and passes them to a sink, kPlyBatchRows at a time.
class PlyVertexBatch {
 public:
  /// Allocates memory for at most kPlyBatchRows vertices, even if the file declares more.
  PlyVertexBatch(const VertexPlan& plan, const PlyReader::VertexSink& sink, PlyCounts& counts,
                 SkippedVertices& skipped);

  /// Returns space for 1 to kPlyBatchRows vertices. Fill the first n of them, then call commit(n).
  std::span<PlyVertex> room() noexcept { return std::span(rows_).subspan(used_); }
  void commit(size_t vertices);
  /// Counts a defect of the uncommitted vertex at room()[index].
  void countDefect(size_t index, VertexDefect defect);
  /// Counts a vertex whose colour is clamped.
  void countClamped() noexcept { ++counts_.clamped_colours; }
  void flush();
  /// Counts the committed vertices without passing them to the sink.
  void countRest() noexcept {
    counts_.vertices += used_;
    used_ = 0;
  }

 private:
  void countNormals();

  const bool has_normals_;
  const PlyReader::VertexSink& sink_;
  PlyCounts& counts_;
  SkippedVertices& skipped_;
  std::vector<PlyVertex> rows_;
  size_t used_ = 0;
};

/// Outcome of PlyFaceBatch::add().
enum class FaceVerdict { kAccepted, kDropped, kSkippedVertex, kBadIndex };

/// Attributes of a face.
struct FaceAttributes {
  std::span<const float> texture = {};  ///< texture coordinates: two numbers per corner, or empty
  int64_t texnumber = 0;
  glm::u8vec4 colour{255};
};

/// Collects faces, drops degenerate faces, and passes the remaining faces to a sink in batches. If many
/// consecutive faces are dropped, passes on an empty batch.
class PlyFaceBatch {
 public:
  PlyFaceBatch(const PlyPlan& plan, const PlyReader::FaceSink& sink, PlyCounts& counts,
               const SkippedVertices& skipped);

  bool isVertex(int64_t index) const noexcept { return static_cast<uint64_t>(index) < vertex_count_; }

  /// Adds a face, or counts the face as dropped or skipped.
  FaceVerdict add(std::span<const int64_t> corners, const FaceAttributes& attributes);
  void addTriangle(const std::array<int64_t, 3>& corners) { add(corners, {}); }
  /// Counts a row of the face element, or a triangle strip.
  void countFace() noexcept { ++counts_.faces; }
  /// Counts a face that the caller skips.
  void countSkipped(size_t corners) noexcept {
    ++counts_.skipped_bad;
    countDropped(corners);
  }
  /// Counts a face with a clamped colour.
  void countClamped() noexcept { ++counts_.clamped_colours; }
  /// Counts a face with a NaN or infinite colour, which becomes zero.
  void countReplaced() noexcept { ++counts_.replaced_attributes; }
  /// Counts faces without corners as dropped.
  void addEmpty(uint64_t faces);
  void flush();

 private:
  /// Counts faces that are left out of the batch. Flushes the batch after many such faces, so that progress
  /// is reported.
  void noteLeftOut(uint64_t faces);
  FaceVerdict judge(std::span<const int64_t> corners);
  void countDropped(size_t corners) noexcept { counts_.dropped_triangles += corners > 2 ? corners - 2 : 0; }
  uint16_t takeMaterial(int64_t texnumber);

  uint64_t vertex_count_;
  bool corner_texture_;
  bool materials_;
  bool colours_;
  uint64_t textures_;  ///< number of textures in the header; 0 without texture coordinates
  const PlyReader::FaceSink& sink_;
  PlyCounts& counts_;
  const SkippedVertices& skipped_;
  PlyFaces faces_;
  uint64_t left_out_ = 0;  ///< faces dropped or skipped since the last flush
  std::vector<int64_t> sorted_;
};

/// Cuts triangle strips into triangles. The caller passes one index at a time; the index -1 separates strips.
class StripCutter {
 public:
  explicit StripCutter(PlyFaceBatch& batch) : batch_(batch) {}

  static bool isRestart(int64_t index) noexcept { return index == -1 || index == int64_t{UINT32_MAX}; }
  void add(int64_t index);
  void end() noexcept { length_ = 0; }

 private:
  PlyFaceBatch& batch_;
  int64_t before_last_ = 0;
  int64_t last_ = 0;
  uint64_t length_ = 0;  ///< number of indices of the current strip so far
};

}  // namespace lode::ingest
