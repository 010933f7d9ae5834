#include "server/ingest/ply_body.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace lode::ingest {
namespace {

constexpr const char* kRepair = "repair the file or use --skip-bad";

}  // namespace

void PlyBody::fail(const std::string& what, const std::string& remedy) const {
  throw Error(ErrorCode::kInput, input_.name() + ": " + element_->name + " " + std::to_string(row_) + " at " +
                                     where() + ": " + what + "; " + remedy);
}

void PlyBody::failTruncated() const {
  throw Error(ErrorCode::kInput, input_.name() + " is truncated: it ends at byte " +
                                     std::to_string(input_.size()) + ", before the end of " + element_->name +
                                     " " + std::to_string(row_) + " of " + std::to_string(element_->count) +
                                     " at " + where() + "; copy or export the file again");
}

void PlyBody::failIndex(int64_t index) const { fail("there is no vertex " + std::to_string(index), kRepair); }

void PlyBody::judgeVertex(VertexDefect defect, size_t index, VertexBatch& batch) const {
  if (defect == VertexDefect::kNone) return;
  if (!options_.skip_bad) {
    fail(defect == VertexDefect::kPosition ? "its position is NaN or infinite"
                                           : "an attribute is NaN or infinite",
         kRepair);
  }
  batch.countDefect(index, defect);
}

void PlyBody::giveFace(uint16_t material, FaceBatch& batch) {
  batch.countFace();
  const bool is_face = corners_.size() >= 3;
  if (is_face && !texture_.empty()) {
    std::string defect;
    if (texture_.size() != 2 * corners_.size()) {
      defect = std::to_string(texture_.size()) + " texture coordinates for " +
               std::to_string(corners_.size()) + " corners, which need two each";
    } else if (!std::all_of(texture_.begin(), texture_.end(),
                            [](float value) { return std::isfinite(value); })) {
      defect = "a texture coordinate is NaN or infinite";
    }
    if (!defect.empty() && !options_.skip_bad) fail(defect, kRepair);
    if (!defect.empty()) return batch.countSkipped();
  }
  const std::span<const float> texture =
      is_face ? std::span<const float>(texture_) : std::span<const float>();
  if (batch.add(corners_, texture, material) == FaceVerdict::kBadIndex && !options_.skip_bad) {
    failIndex(*std::find_if(corners_.begin(), corners_.end(), [&](int64_t i) { return !batch.isVertex(i); }));
  }
}

void PlyBody::giveStripIndex(int64_t index, StripCutter& strip, const FaceBatch& batch) const {
  if (!options_.skip_bad && !StripCutter::isRestart(index) && !batch.isVertex(index)) failIndex(index);
  strip.add(index);
}

void PlyBody::checkListLength(const PlyProperty& list, FaceRole role, uint64_t count) const {
  const uint64_t limit = role == FaceRole::kTexture ? 2 * kMaxFaceCorners : kMaxFaceCorners;
  if (count <= limit) return;
  fail("list " + list.name + " has " + std::to_string(count) + " items, more than " + std::to_string(limit),
       "cut the face into smaller ones");
}

uint16_t PlyBody::materialNumber(double texnumber) noexcept {
  return texnumber >= 0 && texnumber < kNoMaterial ? static_cast<uint16_t>(texnumber) : kNoMaterial;
}

}  // namespace lode::ingest
