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
/// Corners of one face; ear clipping takes up to the square of it.
constexpr uint64_t kMaxFaceCorners = 1u << 16;

/// Vertex numbers that were skipped. Memory: a bit for each vertex at worst, where there are any skipped
/// ones.
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

/// Collects vertices and hands them on kPlyBatchRows at a time.
class PlyVertexBatch {
 public:
  /// @param plan  of the vertices that will come; takes memory for no more than kPlyBatchRows of them.
  PlyVertexBatch(const VertexPlan& plan, const PlyReader::VertexSink& sink, PlyCounts& counts,
                 SkippedVertices& skipped);

  /// Room for at least one and at most kPlyBatchRows vertices, to be filled and handed to commit().
  std::span<PlyVertex> room() noexcept { return std::span(rows_).subspan(used_); }
  void commit(size_t vertices);
  /// Counts a defect of the vertex at room()[index], not yet committed.
  void countDefect(size_t index, VertexDefect defect);
  /// Counts a vertex whose colour is clamped.
  void countClamped() noexcept { ++counts_.clamped_colours; }
  void flush();
  /// Counts those that nobody will be handed.
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

/// What became of a face.
enum class FaceVerdict { kAccepted, kDropped, kSkippedVertex, kBadIndex };

/// Collects faces, drops those that are none, and hands the others on in batches.
class PlyFaceBatch {
 public:
  PlyFaceBatch(const PlyPlan& plan, const PlyReader::FaceSink& sink, PlyCounts& counts,
               const SkippedVertices& skipped);

  bool isVertex(int64_t index) const noexcept { return static_cast<uint64_t>(index) < vertex_count_; }

  /// Counts whatever it does not accept, a bad index as skipped.
  /// @param texture  two numbers a corner, or empty.
  FaceVerdict add(std::span<const int64_t> corners, std::span<const float> texture, int64_t texnumber);
  void addTriangle(const std::array<int64_t, 3>& corners) { add(corners, {}, 0); }
  /// Counts a row of the face element, or a strip.
  void countFace() noexcept { ++counts_.faces; }
  /// Counts a face that is left out for a reason that the caller knows.
  void countSkipped(size_t corners) noexcept {
    ++counts_.skipped_bad;
    countDropped(corners);
  }
  void flush();

 private:
  FaceVerdict judge(std::span<const int64_t> corners);
  void countDropped(size_t corners) noexcept { counts_.dropped_triangles += corners > 2 ? corners - 2 : 0; }
  uint16_t takeMaterial(int64_t texnumber);

  uint64_t vertex_count_;
  bool corner_texture_;
  bool materials_;
  uint64_t textures_;  ///< 0 also where there are no coordinates for them
  const PlyReader::FaceSink& sink_;
  PlyCounts& counts_;
  const SkippedVertices& skipped_;
  PlyFaces faces_;
  std::vector<int64_t> sorted_;
};

/// Cuts strips into triangles, index by index; -1 ends a strip and begins the next.
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
  uint64_t length_ = 0;  ///< indices of this strip so far
};

}  // namespace lode::ingest
