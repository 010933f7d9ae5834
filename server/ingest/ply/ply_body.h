#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/ingest/ply/ply_batch.h"
#include "server/ingest/ply/ply_input.h"
#include "server/ingest/ply/ply_plan.h"

namespace lode::ingest {

/// Position between two elements of the body.
struct PlyPlace {
  uint64_t offset = 0;  ///< bytes from the start of the file
  uint64_t line = 0;    ///< line number from 1; ascii files only
};

/// Reads the elements of a PLY file's body. Each encoding has its own implementation. All functions throw
/// Error kInput, whose message contains the element's name, the row (from 0), and the byte or, in ascii, the
/// line.
class PlyBody {
 public:
  virtual ~PlyBody() = default;
  PlyBody(const PlyBody&) = delete;
  PlyBody& operator=(const PlyBody&) = delete;

  virtual void readVertices(const VertexPlan& plan, PlyVertexBatch& batch) = 0;
  virtual void readFaces(const FacePlan& plan, PlyFaceBatch& batch) = 0;
  virtual void skip(const PlyElement& element) = 0;

  virtual PlyPlace place() const noexcept = 0;
  virtual void goTo(PlyPlace place) = 0;
  /// Returns the smallest possible size of an element's row.
  virtual uint64_t leastRowBytes(const PlyElement& element) const noexcept = 0;

 protected:
  PlyBody(PlyInput& input, PlyReadOptions options) : input_(input), options_(options) {}

  /// Returns the position of the current row: "byte 12" or "line 3".
  virtual std::string where() const = 0;
  [[noreturn]] void fail(const std::string& what, const std::string& remedy) const;
  /// Fails because the file is too short. @param how  text appended to the remedy; begins with a comma.
  [[noreturn]] void failTruncated(const std::string& how = {}) const;

  /// Reports a defect of the current row, or of several rows from the current row on, to options.on_defect.
  void reportDefect(bool is_bad, const std::string& what, uint64_t rows = 1) const;
  /// Handles a defect of the vertex at batch.room()[index]. Counts a colour out of range. Counts any other
  /// defect if skip_bad is set, else fails.
  void handleVertexDefect(VertexDefect defect, size_t index, PlyVertexBatch& batch) const;
  /// Resets the values of the current face, before a row of the face element is read.
  void beginFace() noexcept;
  /// Stores the value of a property that is not a list, for the current face.
  /// @param role  kMaterial, kRed, kGreen, kBlue or kAlpha.
  void takeFaceValue(FaceRole role, PlyType type, double value) noexcept;
  /// Adds the current face to the batch.
  void addFace(PlyFaceBatch& batch);
  /// Counts and reports faces without corners, from the current row on.
  void addEmptyFaces(uint64_t rows, PlyFaceBatch& batch) const;
  void addStripIndex(int64_t index, StripCutter& strip, const PlyFaceBatch& batch) const;
  void checkListLength(const PlyProperty& list, FaceRole role, uint64_t count) const;

  PlyInput& input_;
  PlyReadOptions options_;
  const PlyElement* element_ = nullptr;
  uint64_t row_ = 0;
  std::vector<int64_t> corners_;  ///< vertex indices of the current face
  std::vector<float> texture_;    ///< texture coordinates of the current face, two numbers per corner

 private:
  /// Returns the problem with the current face's texture coordinates, or an empty string.
  std::string textureProblem() const;
  /// Handles a bad colour of the current face: counts the face if the colour is out of range or skip_bad is
  /// set, else fails.
  void handleColourDefect(PlyFaceBatch& batch) const;
  /// Handles a corner whose vertex does not exist: reports the corner if skip_bad is set, else fails.
  void handleBadIndex(int64_t index) const;

  int64_t texnumber_ = 0;    ///< texnumber of the current face
  glm::u8vec4 colour_{255};  ///< colour of the current face
  VertexDefect colour_defect_ = VertexDefect::kNone;
};

std::unique_ptr<PlyBody> makeBinaryBody(PlyInput& input, PlyEncoding encoding, PlyReadOptions options);
/// @param first_line    line number of the body's first line, from 1.
/// @param extra_tokens  receives the number of surplus values at the ends of rows.
std::unique_ptr<PlyBody> makeAsciiBody(PlyInput& input, PlyReadOptions options, uint64_t first_line,
                                       uint64_t& extra_tokens);

}  // namespace lode::ingest
