#include "server/ingest/ply/ply_batch.h"

#include <algorithm>
#include <utility>

#include "common/codec/octahedral.h"

namespace lode::ingest {

void SkippedVertices::add(uint64_t vertex) {
  const size_t page = static_cast<size_t>(vertex / kPageBits);
  if (page >= pages_.size()) pages_.resize(page + 1);
  if (!pages_[page]) pages_[page] = std::make_unique<Page>();
  (*pages_[page])[vertex % kPageBits / 64] |= uint64_t{1} << (vertex % 64);
}

bool SkippedVertices::contains(uint64_t vertex) const noexcept {
  const size_t page = static_cast<size_t>(vertex / kPageBits);
  if (page >= pages_.size() || !pages_[page]) return false;
  return ((*pages_[page])[vertex % kPageBits / 64] >> (vertex % 64) & 1) != 0;
}

PlyVertexBatch::PlyVertexBatch(const VertexPlan& plan, const PlyReader::VertexSink& sink, PlyCounts& counts,
                               SkippedVertices& skipped)
    : has_normals_(plan.attributes.has(AttributeSet::kNormal)),
      sink_(sink),
      counts_(counts),
      skipped_(skipped),
      rows_(static_cast<size_t>(std::min<uint64_t>(plan.element->count, kPlyBatchRows))) {}

void PlyVertexBatch::countDefect(size_t index, VertexDefect defect) {
  if (defect != VertexDefect::kPosition) {
    ++counts_.replaced_attributes;
    return;
  }
  ++counts_.skipped_bad;
  skipped_.add(counts_.vertices + used_ + index);
}

void PlyVertexBatch::commit(size_t vertices) {
  used_ += vertices;
  if (used_ == rows_.size()) flush();
}

void PlyVertexBatch::countNormals() {
  for (size_t i = 0; i < used_; ++i) {
    const bool has_length = hasDirection(rows_[i].normal);
    if (!has_length && skipped_.contains(counts_.vertices + i)) continue;
    ++counts_.normals;
    counts_.lengthless_normals += !has_length;
  }
}

void PlyVertexBatch::flush() {
  if (used_ == 0) return;
  if (has_normals_) countNormals();
  const uint64_t first = counts_.vertices;
  // Reset the count before the sink can throw, so that each vertex counts once.
  const size_t count = std::exchange(used_, 0);
  counts_.vertices += count;
  if (sink_) sink_(first, std::span<const PlyVertex>(rows_).first(count));
}

PlyFaceBatch::PlyFaceBatch(const PlyPlan& plan, const PlyReader::FaceSink& sink, PlyCounts& counts,
                           const SkippedVertices& skipped)
    : vertex_count_(plan.vertices.element->count),
      corner_texture_(plan.corner_texture),
      materials_(plan.materials),
      colours_(plan.face_colours.bits != 0),
      textures_(plan.attributes().has(AttributeSet::kTexture) ? plan.textures : 0),
      sink_(sink),
      counts_(counts),
      skipped_(skipped) {}

FaceVerdict PlyFaceBatch::judge(std::span<const int64_t> corners) {
  for (const int64_t corner : corners) {
    if (!isVertex(corner)) return FaceVerdict::kBadIndex;
  }
  if (corners.size() < 3) return FaceVerdict::kDropped;
  if (corners.size() == 3) {
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
      return FaceVerdict::kDropped;
  } else {
    sorted_.assign(corners.begin(), corners.end());
    std::sort(sorted_.begin(), sorted_.end());
    if (std::adjacent_find(sorted_.begin(), sorted_.end()) != sorted_.end()) return FaceVerdict::kDropped;
  }
  if (skipped_.any()) {
    for (const int64_t corner : corners) {
      if (skipped_.contains(static_cast<uint64_t>(corner))) return FaceVerdict::kSkippedVertex;
    }
  }
  return FaceVerdict::kAccepted;
}

FaceVerdict PlyFaceBatch::add(std::span<const int64_t> corners, const FaceAttributes& attributes) {
  const FaceVerdict verdict = judge(corners);
  if (verdict != FaceVerdict::kAccepted) {
    ++(verdict == FaceVerdict::kDropped ? counts_.dropped_faces : counts_.skipped_bad);
    countDropped(corners.size());
    noteLeftOut(1);
    return verdict;
  }
  counts_.triangles += corners.size() - 2;
  faces_.corner_counts.push_back(static_cast<uint32_t>(corners.size()));
  for (const int64_t corner : corners) faces_.corners.push_back(static_cast<uint64_t>(corner));
  if (corner_texture_) {
    const std::span<const float> texture = attributes.texture;
    for (size_t i = 0; i < corners.size(); ++i) {
      faces_.texture.push_back(texture.empty() ? glm::vec2(0)
                                               : glm::vec2(texture[2 * i], texture[2 * i + 1]));
    }
  }
  if (materials_) faces_.materials.push_back(takeMaterial(attributes.texnumber));
  if (colours_) faces_.colours.push_back(attributes.colour);
  if (faces_.corner_counts.size() >= kPlyBatchRows || faces_.corners.size() >= 8 * kPlyBatchRows) flush();
  return verdict;
}

uint16_t PlyFaceBatch::takeMaterial(int64_t texnumber) {
  constexpr int64_t kNone = -1;
  const auto number = static_cast<uint64_t>(texnumber);  // a negative number becomes larger than all others
  counts_.unknown_textures += textures_ > 0 && texnumber != kNone && number >= textures_;
  return number < kNoMaterial ? static_cast<uint16_t>(number) : kNoMaterial;
}

void PlyFaceBatch::addEmpty(uint64_t faces) {
  counts_.faces += faces;
  counts_.dropped_faces += faces;
  noteLeftOut(faces);
}

void PlyFaceBatch::noteLeftOut(uint64_t faces) {
  left_out_ += faces;
  if (left_out_ >= kPlyBatchRows) flush();
}

void PlyFaceBatch::flush() {
  if (faces_.corner_counts.empty() && left_out_ == 0) return;
  left_out_ = 0;
  if (sink_) sink_(faces_);
  faces_.clear();
}

void StripCutter::add(int64_t index) {
  if (isRestart(index)) return end();
  if (length_ == 0) batch_.countFace();
  if (length_ >= 2) {
    const bool odd = length_ % 2 != 0;
    batch_.addTriangle({odd ? last_ : before_last_, odd ? before_last_ : last_, index});
  }
  before_last_ = last_;
  last_ = index;
  ++length_;
}

}  // namespace lode::ingest
