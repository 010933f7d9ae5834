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

/// Field of a vertex that a property is read into.
enum class VertexField : uint8_t { kX, kY, kZ, kNx, kNy, kNz, kRed, kGreen, kBlue, kAlpha, kS, kT, kNone };
constexpr size_t kVertexFields = static_cast<size_t>(VertexField::kNone);

/// Values of one vertex in the file, indexed by VertexField. Fields that the file lacks have undefined
/// values.
using VertexValues = std::array<double, kVertexFields>;

/// Describes how rows of the vertex element are read as vertices.
struct VertexPlan {
  const PlyElement* element = nullptr;
  std::vector<VertexField> fields;                ///< field of each property; kNone: the property is skipped
  std::array<PlyType, kVertexFields> types{};     ///< type of each field's property
  std::array<bool, kVertexFields> has{};          ///< true if the file has the field
  std::array<uint32_t, kVertexFields> offsets{};  ///< offset of each field in a binary row, if row_bytes > 0
  uint32_t row_bytes = 0;  ///< size of a binary row; 0 if rows contain lists and therefore vary in size
  AttributeSet attributes;
};

/// Part of a face that a property of the face or tristrips element is read into.
enum class FaceRole : uint8_t { kSkipped, kIndices, kTexture, kMaterial, kRed, kGreen, kBlue, kAlpha };
constexpr bool isColourRole(FaceRole role) noexcept { return role >= FaceRole::kRed; }

/// Describes how rows of a face or tristrips element are read as faces.
struct FacePlan {
  const PlyElement* element = nullptr;
  bool strips = false;
  std::vector<FaceRole> roles;  ///< role of each property
  AttributeSet colours;         ///< kColour and kAlpha if faces have them
};

struct PlyPlan {
  VertexPlan vertices;
  std::vector<FacePlan> faces;        ///< plans of face and tristrips elements that have rows, in file order
  bool corner_texture = false;        ///< true if a face element has texcoord
  bool materials = false;             ///< true if a face element has texnumber
  AttributeSet face_colours;          ///< kColour and kAlpha if faces have them and vertices do not
  bool ignores_face_colours = false;  ///< true if face colours are ignored because vertices have colours
  size_t textures = 0;                ///< number of textures that the header names

  AttributeSet attributes() const noexcept;
  /// Returns the attributes that are stored per face or per corner instead of per vertex.
  AttributeSet faceAttributes() const noexcept;
};

/// Plans how to read the body. The plan points into the header, which must outlive it.
/// @param file  quoted name of the file, for messages.
/// @throws Error kInput if the file has no vertices or no faces, or if a required property is missing.
PlyPlan planBody(const PlyHeader& header, const std::string& file);

/// Lists the properties that the plan skips, in header order, as "element 'property'". If the plan skips a
/// whole element, lists "all of 'element'" instead. Omits elements without rows.
std::vector<std::string> skippedProperties(const PlyHeader& header, const PlyPlan& plan);

/// Calls visit(std::type_identity<T>) with the C++ type of a PLY type.
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

/// Converts a colour value to a byte. Clamps the value to the range of its type: 0 to 1 for floating types,
/// 0 to 65535 for ushort, 0 to 255 for other types. Treats char as uchar. Returns 0 for NaN.
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

/// Returns true if a value is within the range of colourByte(), with a tolerance for rounding. Returns false
/// for NaN.
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

/// Converts a colour value of a property's type to a byte. @param fits  set to false if isColour() is false.
inline uint8_t colourByte(PlyType type, double value, bool& fits) noexcept {
  return withPlyType(type, [&]<class T>(std::type_identity<T>) {
    fits = fits && isColour(static_cast<T>(value));
    return colourByte(static_cast<T>(value));
  });
}

/// Worst defect of a vertex, in order of increasing severity: none, a colour out of range, a NaN or infinite
/// attribute, a NaN or infinite position.
enum class VertexDefect { kNone, kColour, kAttribute, kPosition };

/// Turns the values of one row into a vertex. Attributes that are NaN or infinite become zero.
/// If the position is NaN or infinite, the whole vertex becomes zero. @return the worst defect.
VertexDefect makeVertex(const VertexPlan& plan, const VertexValues& values, PlyVertex& vertex);

}  // namespace lode::ingest
