#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "common/mesh.h"
#include "server/ingest/ply/ply_header.h"
#include "server/ingest/ply/ply_reader.h"

namespace lode::ingest {

/// What a vertex property is read into.
enum class VertexField : uint8_t { kX, kY, kZ, kNx, kNy, kNz, kRed, kGreen, kBlue, kAlpha, kS, kT, kNone };
constexpr size_t kVertexFields = static_cast<size_t>(VertexField::kNone);

/// Values of one vertex as the file has them, by VertexField; fields that the file lacks are not looked at.
using VertexValues = std::array<double, kVertexFields>;

/// How the rows of the vertex element become vertices.
struct VertexPlan {
  const PlyElement* element = nullptr;
  std::vector<VertexField> fields;                ///< one a property, kNone where it is skipped
  std::array<PlyType, kVertexFields> types{};     ///< of the property behind each field
  std::array<bool, kVertexFields> has{};          ///< the file has the field
  std::array<uint32_t, kVertexFields> offsets{};  ///< of the field in a binary row, where row_bytes > 0
  uint32_t row_bytes = 0;                         ///< of a binary row, or 0 where a list makes rows differ
  AttributeSet attributes;
};

/// What a property of the face element or of the tristrips element is read into.
enum class FaceRole : uint8_t { kSkipped, kIndices, kTexture, kMaterial };

/// How the rows of the face or tristrips element become faces.
struct FacePlan {
  const PlyElement* element = nullptr;
  bool strips = false;
  std::vector<FaceRole> roles;  ///< one a property
};

struct PlyPlan {
  VertexPlan vertices;
  std::vector<FacePlan> faces;  ///< face and tristrips, those with rows, in the file's order
  bool corner_texture = false;  ///< a face element has texcoord
  bool materials = false;       ///< a face element has texnumber
  size_t textures = 0;          ///< that the header names

  AttributeSet attributes() const noexcept;
};

/// The plan points into the header.
/// @param file  quoted, for messages.
/// @throws Error kInput: no vertices, no faces, or an element that lacks what it needs.
PlyPlan planBody(const PlyHeader& header, const std::string& file);

/// The properties of elements with rows that nothing is read from, in the header's order, each as
/// "element 'property'", quoted for messages; an element of which nothing is read is one entry, "all of
/// 'element'".
std::vector<std::string> skippedProperties(const PlyHeader& header, const PlyPlan& plan);

/// Calls visit(std::type_identity<T>) with the C++ type behind a PLY type.
template <class Visit>
decltype(auto) withPlyType(PlyType type, Visit&& visit) {
  switch (type) {
    case PlyType::kInt8:
      return visit(std::type_identity<int8_t>{});
    case PlyType::kUint8:
      return visit(std::type_identity<uint8_t>{});
    case PlyType::kInt16:
      return visit(std::type_identity<int16_t>{});
    case PlyType::kUint16:
      return visit(std::type_identity<uint16_t>{});
    case PlyType::kInt32:
      return visit(std::type_identity<int32_t>{});
    case PlyType::kUint32:
      return visit(std::type_identity<uint32_t>{});
    case PlyType::kFloat32:
      return visit(std::type_identity<float>{});
    case PlyType::kFloat64:
      break;
  }
  return visit(std::type_identity<double>{});
}

/// A colour value as a byte: floating types run from 0 to 1, ushort from 0 to 65535, all others from 0 to
/// 255; beyond that they are clamped. char is taken as uchar. A value that is not a number gives 0.
template <class T>
uint8_t colourByte(T value) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    return value > T(0) ? static_cast<uint8_t>(std::fmin(value, T(1)) * T(255) + T(0.5)) : uint8_t{0};
  } else if constexpr (sizeof(T) == 1) {
    return static_cast<uint8_t>(value);
  } else if constexpr (std::is_same_v<T, uint16_t>) {
    return static_cast<uint8_t>((value * 255u + 32767u) / 65535u);
  } else {
    return value <= T(0) ? uint8_t{0} : value >= T(255) ? uint8_t{255} : static_cast<uint8_t>(value);
  }
}

/// Whether colourByte() keeps a value, to within its rounding, rather than clamping it. NaN is not kept.
template <class T>
bool isColour(T value) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    constexpr T kHalfByte = T(0.5) / T(255);
    return value > -kHalfByte && value < T(1) + kHalfByte;
  } else if constexpr (sizeof(T) == 1 || std::is_same_v<T, uint16_t>) {
    return true;
  } else {
    return std::clamp(value, T(0), T(255)) == value;
  }
}

/// What is wrong with the values of a vertex, the worst last: a colour that is clamped, an attribute or the
/// position that is NaN or infinite.
enum class VertexDefect { kNone, kColour, kAttribute, kPosition };

/// Turns the values of one row into a vertex. Attributes that are NaN or infinite become zero.
/// @return the worst defect: with a position that is NaN or infinite the vertex is all zero.
VertexDefect makeVertex(const VertexPlan& plan, const VertexValues& values, PlyVertex& vertex);

}  // namespace lode::ingest
