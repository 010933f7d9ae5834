#include "server/ingest/ply/ply_body.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace lode::ingest {
namespace {

constexpr const char* kTooFewCorners = "it has fewer than three corners";
constexpr const char* kRepair = "repair the file, or build it with lodestreamd build --skip-bad";

}  // namespace

void PlyBody::fail(const std::string& what, const std::string& remedy) const {
  throw Error(ErrorCode::kInput, input_.name() + ": " + element_->name + " " + std::to_string(row_) + " at " +
                                     where() + ": " + what + "; " + remedy);
}

void PlyBody::failTruncated(const std::string& how) const {
  throw Error(ErrorCode::kInput, input_.name() + " is truncated: it ends at byte " +
                                     std::to_string(input_.size()) + ", before the end of " + element_->name +
                                     " " + std::to_string(row_) + " of " + std::to_string(element_->count) +
                                     " at " + where() + "; copy or export the file again" + how);
}

void PlyBody::reportDefect(bool is_bad, const std::string& what, uint64_t rows) const {
  if (!options_.on_defect) return;
  options_.on_defect(
      {is_bad, element_->name + " " + std::to_string(row_) + " at " + where() + ": " + what, rows});
}

void PlyBody::addEmptyFaces(uint64_t rows, PlyFaceBatch& batch) const {
  batch.addEmpty(rows);
  reportDefect(false, kTooFewCorners, rows);
}

void PlyBody::handleBadIndex(int64_t index) const {
  const std::string what = "there is no vertex " + std::to_string(index);
  if (!options_.skip_bad) fail(what, kRepair);
  reportDefect(true, what);
}

void PlyBody::handleVertexDefect(VertexDefect defect, size_t index, PlyVertexBatch& batch) const {
  if (defect == VertexDefect::kNone) return;
  if (defect == VertexDefect::kColour) return batch.countClamped();
  const char* what = defect == VertexDefect::kPosition ? "its position is NaN or infinite"
                                                       : "an attribute is NaN or infinite";
  if (!options_.skip_bad) fail(what, kRepair);
  reportDefect(true, what);
  batch.countDefect(index, defect);
}

void PlyBody::beginFace() noexcept {
  corners_.clear();
  texture_.clear();
  texnumber_ = 0;
  colour_ = glm::u8vec4(255);
  colour_defect_ = VertexDefect::kNone;
}

void PlyBody::takeFaceValue(FaceRole role, PlyType type, double value) noexcept {
  if (role == FaceRole::kMaterial) {
    texnumber_ = static_cast<int64_t>(value);
    return;
  }
  bool fits = true;
  const bool is_finite = std::isfinite(value);
  colour_[static_cast<int>(role) - static_cast<int>(FaceRole::kRed)] =
      is_finite ? colourByte(type, value, fits) : uint8_t{0};
  colour_defect_ = std::max(colour_defect_, !is_finite ? VertexDefect::kAttribute
                                            : !fits    ? VertexDefect::kColour
                                                       : VertexDefect::kNone);
}

std::string PlyBody::textureProblem() const {
  if (texture_.size() != 2 * corners_.size())
    return std::to_string(texture_.size()) + " texture coordinates for " + std::to_string(corners_.size()) +
           " corners, which need two each";
  if (!std::all_of(texture_.begin(), texture_.end(), [](float value) { return std::isfinite(value); }))
    return "a texture coordinate is NaN or infinite";
  return {};
}

void PlyBody::handleColourDefect(PlyFaceBatch& batch) const {
  if (colour_defect_ == VertexDefect::kNone) return;
  if (colour_defect_ == VertexDefect::kColour) return batch.countClamped();
  const std::string what = "a colour is NaN or infinite";
  if (!options_.skip_bad) fail(what, kRepair);
  reportDefect(true, what);
  batch.countReplaced();
}

void PlyBody::addFace(PlyFaceBatch& batch) {
  batch.countFace();
  const bool is_face = corners_.size() >= 3;
  if (is_face && !texture_.empty()) {
    const std::string defect = textureProblem();
    if (!defect.empty() && !options_.skip_bad) fail(defect, kRepair);
    if (!defect.empty()) {
      reportDefect(true, defect);
      return batch.countSkipped(corners_.size());
    }
  }
  FaceAttributes attributes{{}, texnumber_, colour_};
  if (is_face) attributes.texture = texture_;
  const FaceVerdict verdict = batch.add(corners_, attributes);
  if (verdict == FaceVerdict::kAccepted) {
    handleColourDefect(batch);
  } else if (verdict == FaceVerdict::kBadIndex) {
    handleBadIndex(
        *std::find_if(corners_.begin(), corners_.end(), [&](int64_t i) { return !batch.isVertex(i); }));
  } else if (verdict == FaceVerdict::kDropped) {
    reportDefect(false, corners_.size() < 3 ? kTooFewCorners : "it uses a vertex twice");
  }
}

void PlyBody::addStripIndex(int64_t index, StripCutter& strip, const PlyFaceBatch& batch) const {
  if (!StripCutter::isRestart(index) && !batch.isVertex(index)) handleBadIndex(index);
  strip.add(index);
}

void PlyBody::checkListLength(const PlyProperty& list, FaceRole role, uint64_t count) const {
  const uint64_t limit = role == FaceRole::kTexture ? 2 * kMaxFaceCorners : kMaxFaceCorners;
  if (count <= limit) return;
  fail("list " + list.name + " has " + std::to_string(count) + " items, more than " + std::to_string(limit),
       "split the face");
}

}  // namespace lode::ingest
