#include "server/ingest/soup/packed_input.h"

#include <algorithm>
#include <array>
#include <string>

#include "common/codec/octahedral.h"
#include "common/error.h"
#include "server/ingest/mesh/vertex_set.h"

namespace lode::ingest {
namespace {

uint16_t normalCode(glm::vec3 normal) noexcept {
  return hasDirection(normal) ? encodeOctahedral(normal) : kNoNormal;
}

}  // namespace

AttributeSet vertexAttributes(AttributeSet attributes, AttributeSet face_attributes) noexcept {
  const auto elsewhere = static_cast<uint8_t>(face_attributes.bits | AttributeSet::kMaterial);
  return {static_cast<uint8_t>(attributes.bits & ~elsewhere)};
}

size_t packedVertexBytes(AttributeSet vertex_attributes, bool double_positions) noexcept {
  return (double_positions ? sizeof(glm::dvec3) : sizeof(glm::vec3)) +
         (vertex_attributes.bits != 0 ? sizeof(VertexAttributes) : 0) +
         (vertex_attributes.has(AttributeSet::kTexture) ? sizeof(glm::vec2) : 0);
}

PackedInput::PackedInput(const TemporaryFolder& folder, AttributeSet attributes, bool double_positions,
                         AttributeSet face_attributes)
    : attributes_(attributes),
      face_attributes_(face_attributes),
      double_positions_(double_positions),
      vertex_attributes_(vertexAttributes(attributes, face_attributes)),
      vertex_bytes_(packedVertexBytes(vertex_attributes_, double_positions)),
      vertex_spool_(folder.lastingFile(kVertexFile)),
      face_spool_(folder.lastingFile(kFaceFile)) {}

PackedInput::PackedInput(const TemporaryFolder& folder, const Place& place)
    : attributes_(place.attributes),
      face_attributes_(place.face_attributes),
      double_positions_(place.double_positions != 0),
      vertex_attributes_(vertexAttributes(attributes_, face_attributes_)),
      vertex_bytes_(packedVertexBytes(vertex_attributes_, double_positions_)),
      vertex_spool_(folder.lastingFile(kVertexFile), place.vertex_bytes),
      face_spool_(folder.lastingFile(kFaceFile), place.face_bytes),
      vertices_(place.vertices),
      faces_(place.faces),
      uv_grid_(place.uv_grid) {}

void PackedInput::save(RecordWriter& record) const {
  vertex_spool_.sync();
  face_spool_.sync();
  record.put(Place{vertex_spool_.size(), face_spool_.size(), vertices_, faces_, uv_grid_, attributes_,
                   face_attributes_, double_positions_});
}

PackedInput PackedInput::load(const TemporaryFolder& folder, RecordReader& record) {
  const auto place = record.get<Place>();
  PackedInput input(folder, place);
  if (place.vertex_bytes % input.vertex_bytes_ != 0 ||
      place.vertex_bytes / input.vertex_bytes_ != place.vertices) {
    throw Error(ErrorCode::kFormat, "the build's journal has a damaged packed input; build without --resume");
  }
  return input;
}

void PackedInput::addVertices(std::span<const PlyVertex> vertices) {
  packed_.resize(vertices.size() * vertex_bytes_);
  std::byte* to = packed_.data();
  for (const PlyVertex& vertex : vertices) {
    const glm::vec3 single(vertex.position);
    const size_t position_bytes = double_positions_ ? sizeof(vertex.position) : sizeof(single);
    if (double_positions_) {
      std::memcpy(to, &vertex.position, position_bytes);
    } else {
      std::memcpy(to, &single, position_bytes);
    }
    if (hasVertexAttributes()) {
      VertexAttributes packed;
      if (attributes_.has(AttributeSet::kNormal)) packed.normal = normalCode(vertex.normal);
      if (vertex_attributes_.has(AttributeSet::kColour)) packed.colour = vertex.colour;
      if (!vertex_attributes_.has(AttributeSet::kAlpha)) packed.colour.a = 255;
      std::memcpy(to + position_bytes, &packed, sizeof(packed));
      if (vertex_attributes_.has(AttributeSet::kTexture)) {
        std::memcpy(to + position_bytes + sizeof(packed), &vertex.texture, sizeof(vertex.texture));
        uv_range_.add(vertex.texture);
      }
    }
    to += vertex_bytes_;
  }
  vertex_spool_.append(std::span<const std::byte>(packed_));
  vertices_ += vertices.size();
}

void PackedInput::addFaces(const PlyFaces& faces) {
  const bool only_triangles =
      std::all_of(faces.corner_counts.begin(), faces.corner_counts.end(), [](uint32_t n) { return n == 3; });
  const std::vector<uint32_t> corners(faces.corners.begin(), faces.corners.end());
  const uint32_t sizes[2] = {only_triangles ? 0 : static_cast<uint32_t>(faces.corner_counts.size()),
                             static_cast<uint32_t>(corners.size())};
  face_spool_.append(std::span<const uint32_t>(sizes));
  if (!only_triangles) face_spool_.append(std::span<const uint32_t>(faces.corner_counts));
  face_spool_.append(std::span<const uint32_t>(corners));
  if (face_attributes_.has(AttributeSet::kTexture)) {
    for (const glm::vec2 uv : faces.texture) uv_range_.add(uv);
    face_spool_.append(std::span<const glm::vec2>(faces.texture));
  }
  if (attributes_.has(AttributeSet::kMaterial))
    face_spool_.append(std::span<const uint16_t>(faces.materials));
  if (face_attributes_.has(AttributeSet::kColour))
    face_spool_.append(std::span<const glm::u8vec4>(faces.colours));
  faces_ += faces.corner_counts.size();
}

glm::dvec3 PackedInput::positionOf(uint64_t vertex) const {
  std::array<std::byte, sizeof(glm::dvec3)> bytes;
  const size_t position_bytes = double_positions_ ? sizeof(glm::dvec3) : sizeof(glm::vec3);
  vertex_spool_.readAt(vertex * vertex_bytes_, std::span(bytes).first(position_bytes));
  return positionIn(bytes.data());
}

UvRange PackedInput::usedUvRange() const {
  if (face_attributes_.has(AttributeSet::kTexture) || uv_range_.withinImage()) return uv_range_;
  VertexSet used(vertices_);
  FaceCursor faces(*this);
  for (FaceBlock block; faces.next(block);)
    for (const uint32_t corner : block.corners) used.add(corner);
  UvRange range;
  SpoolCursor cursor(vertex_spool_, 0, vertices_ * vertex_bytes_);
  for (uint64_t vertex = 0; vertex < vertices_; ++vertex) {
    glm::vec2 uv;  // texture coordinates are the last field of a packed vertex
    std::memcpy(&uv, cursor.take(vertex_bytes_).last(sizeof(uv)).data(), sizeof(uv));
    if (used.contains(vertex)) range.add(uv);
  }
  return range;
}

void PackedInput::flush() {
  vertex_spool_.flush();
  face_spool_.flush();
}

PackedInput::FaceCursor::FaceCursor(const PackedInput& input, uint64_t offset)
    : input_(&input),
      cursor_(input.face_spool_, std::min(offset, input.face_spool_.size()), input.face_spool_.size()) {}

bool PackedInput::FaceCursor::next(FaceBlock& block) {
  if (cursor_.atEnd()) return false;
  uint32_t sizes[2];
  cursor_.take(std::span<uint32_t>(sizes));
  block.corner_counts.resize(sizes[0]);
  block.corners.resize(sizes[1]);
  cursor_.take(std::span<uint32_t>(block.corner_counts));
  cursor_.take(std::span<uint32_t>(block.corners));
  block.texture.clear();
  block.materials.clear();
  block.colours.clear();
  if (input_->face_attributes_.has(AttributeSet::kTexture)) {
    texture_.resize(block.corners.size());
    cursor_.take(std::span<glm::vec2>(texture_));
    block.texture.reserve(texture_.size());
    for (const glm::vec2 uv : texture_) block.texture.push_back(input_->uv_grid_.snap(uv));
  }
  if (input_->attributes_.has(AttributeSet::kMaterial)) {
    block.materials.resize(block.faceCount());
    cursor_.take(std::span<uint16_t>(block.materials));
  }
  if (input_->face_attributes_.has(AttributeSet::kColour)) {
    block.colours.resize(block.faceCount());
    cursor_.take(std::span<glm::u8vec4>(block.colours));
  }
  return true;
}

}  // namespace lode::ingest
