#include "server/ingest/ply/ply_plan.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "common/error.h"
#include "common/printable.h"

namespace lode::ingest {
namespace {

constexpr size_t kShownName = 64;  ///< maximum number of bytes of a name that a message shows

/// Names of the properties that hold a colour.
struct ColourNames {
  std::string_view red, green, blue, alpha;
};
constexpr std::array<ColourNames, 3> kColourNames{
    {{"red", "green", "blue", "alpha"},
     {"diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"},
     {"r", "g", "b", "a"}}};

using Names = std::initializer_list<std::pair<VertexField, std::string_view>>;

/// Returns the first scalar property with a name, or null.
const PlyProperty* findScalar(const PlyElement& element, std::string_view name) {
  for (const PlyProperty& property : element.properties) {
    if (property.name == name && !property.is_list) return &property;
  }
  return nullptr;
}

/// Adds a group of properties to the plan if the element has all of them.
bool takeGroup(VertexPlan& plan, Names names) {
  const std::vector<PlyProperty>& properties = plan.element->properties;
  for (const auto& [field, name] : names) {
    if (findScalar(*plan.element, name) == nullptr) return false;
  }
  for (const auto& [field, name] : names) {
    const PlyProperty* property = findScalar(*plan.element, name);
    plan.fields[static_cast<size_t>(property - properties.data())] = field;
    plan.types[static_cast<size_t>(field)] = property->type;
    plan.has[static_cast<size_t>(field)] = true;
  }
  return true;
}

void layOutRow(VertexPlan& plan) {
  uint32_t offset = 0;
  for (size_t i = 0; i < plan.fields.size(); ++i) {
    const PlyProperty& property = plan.element->properties[i];
    if (property.is_list) return;
    if (plan.fields[i] != VertexField::kNone) plan.offsets[static_cast<size_t>(plan.fields[i])] = offset;
    offset += static_cast<uint32_t>(plyTypeBytes(property.type));
  }
  plan.row_bytes = offset;
}

VertexPlan planVertices(const PlyElement& element, const std::string& file) {
  using enum VertexField;
  VertexPlan plan;
  plan.element = &element;
  plan.fields.assign(element.properties.size(), kNone);
  if (!takeGroup(plan, {{kX, "x"}, {kY, "y"}, {kZ, "z"}})) {
    throw Error(ErrorCode::kInput,
                file + ": the vertex element has no x, y or z; export the mesh again with positions");
  }
  if (takeGroup(plan, {{kNx, "nx"}, {kNy, "ny"}, {kNz, "nz"}})) plan.attributes.bits |= AttributeSet::kNormal;
  for (const ColourNames& names : kColourNames) {
    if (!takeGroup(plan, {{kRed, names.red}, {kGreen, names.green}, {kBlue, names.blue}})) continue;
    plan.attributes.bits |= AttributeSet::kColour;
    if (takeGroup(plan, {{kAlpha, names.alpha}})) plan.attributes.bits |= AttributeSet::kAlpha;
    break;
  }
  if (takeGroup(plan, {{kS, "s"}, {kT, "t"}}) || takeGroup(plan, {{kS, "u"}, {kT, "v"}}) ||
      takeGroup(plan, {{kS, "texture_u"}, {kT, "texture_v"}}) ||
      takeGroup(plan, {{kS, "texture_s"}, {kT, "texture_t"}})) {
    plan.attributes.bits |= AttributeSet::kTexture;
  }
  layOutRow(plan);
  return plan;
}

FacePlan planFaces(const PlyElement& element, bool strips, const std::string& file) {
  FacePlan plan;
  plan.element = &element;
  plan.strips = strips;
  bool has_indices = false;
  for (const PlyProperty& property : element.properties) {
    FaceRole role = FaceRole::kSkipped;
    if (property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index") &&
        !has_indices) {
      if (isFloating(property.type)) {
        throw Error(ErrorCode::kInput,
                    file + ": the " + element.name +
                        " element has vertex numbers of a floating type; export them as int");
      }
      role = FaceRole::kIndices;
      has_indices = true;
    } else if (!strips && property.is_list && property.name == "texcoord" && isFloating(property.type)) {
      role = FaceRole::kTexture;
    } else if (!strips && !property.is_list && property.name == "texnumber" && !isFloating(property.type)) {
      role = FaceRole::kMaterial;
    }
    plan.roles.push_back(role);
  }
  if (!has_indices) {
    throw Error(ErrorCode::kInput,
                file + ": the " + element.name +
                    " element has no list vertex_indices; export the mesh again with its faces");
  }
  return plan;
}

/// Adds the colours of faces to the plan if the element has colours.
void takeFaceColours(FacePlan& plan) {
  const auto take = [&](std::string_view name, FaceRole role) {
    const PlyProperty* const property = findScalar(*plan.element, name);
    if (property != nullptr)
      plan.roles[static_cast<size_t>(property - plan.element->properties.data())] = role;
    return property != nullptr;
  };
  for (const ColourNames& names : kColourNames) {
    if (findScalar(*plan.element, names.red) == nullptr ||
        findScalar(*plan.element, names.green) == nullptr || findScalar(*plan.element, names.blue) == nullptr)
      continue;
    take(names.red, FaceRole::kRed);
    take(names.green, FaceRole::kGreen);
    take(names.blue, FaceRole::kBlue);
    plan.colours.bits = AttributeSet::kColour;
    if (take(names.alpha, FaceRole::kAlpha)) plan.colours.bits |= AttributeSet::kAlpha;
    return;
  }
}

/// Removes the colours of faces from the plan.
void dropFaceColours(FacePlan& plan) {
  for (FaceRole& role : plan.roles) {
    if (isColourRole(role)) role = FaceRole::kSkipped;
  }
  plan.colours = {};
}

/// Returns true if the vertices are the splats of a Gaussian splat. Does not check for colours, because
/// writers name them differently. Some writers pack each group of properties into one property.
bool isGaussianSplat(const PlyElement& vertices) {
  const auto hasAll = [&](const auto& names) {
    return std::ranges::all_of(names,
                               [&](const char* name) { return findScalar(vertices, name) != nullptr; });
  };
  return hasAll(std::array{"opacity", "scale_0", "rot_0", "rot_3"}) ||
         hasAll(std::array{"packed_position", "packed_rotation", "packed_scale"});
}

bool hasRole(const FacePlan& plan, FaceRole role) {
  for (const FaceRole each : plan.roles) {
    if (each == role) return true;
  }
  return false;
}

}  // namespace

AttributeSet PlyPlan::attributes() const noexcept {
  AttributeSet result = vertices.attributes;
  if (corner_texture) result.bits |= AttributeSet::kTexture;
  if (materials) result.bits |= AttributeSet::kMaterial;
  result.bits |= face_colours.bits;
  return result;
}

AttributeSet PlyPlan::faceAttributes() const noexcept {
  AttributeSet result = face_colours;
  if (corner_texture) result.bits |= AttributeSet::kTexture;
  if (materials) result.bits |= AttributeSet::kMaterial;
  return result;
}

PlyPlan planBody(const PlyHeader& header, const std::string& file) {
  PlyPlan plan;
  const PlyElement* vertices = header.find("vertex");
  if (vertices == nullptr || vertices->count == 0) {
    throw Error(ErrorCode::kInput, file + " has no vertices; export the mesh again");
  }
  const bool has_faces = std::ranges::any_of(header.elements, [](const PlyElement& element) {
    return (element.name == "face" || element.name == "tristrips") && element.count > 0;
  });
  if (!has_faces && isGaussianSplat(*vertices)) {
    throw Error(ErrorCode::kInput, file +
                                       " is a Gaussian splat, not a mesh: it has splats with scales and "
                                       "rotations, and no faces; view it with a program for splats, or "
                                       "reconstruct a surface first");
  }
  plan.vertices = planVertices(*vertices, file);
  plan.textures = header.texture_files.size();
  for (const PlyElement& element : header.elements) {
    const bool strips = element.name == "tristrips";
    if ((element.name != "face" && !strips) || element.count == 0) continue;
    plan.faces.push_back(planFaces(element, strips, file));
    plan.corner_texture = plan.corner_texture || hasRole(plan.faces.back(), FaceRole::kTexture);
    plan.materials = plan.materials || hasRole(plan.faces.back(), FaceRole::kMaterial);
    if (strips) continue;
    takeFaceColours(plan.faces.back());
    if (plan.vertices.attributes.has(AttributeSet::kColour)) {
      plan.ignores_face_colours = plan.faces.back().colours.bits != 0;
      dropFaceColours(plan.faces.back());
    }
    plan.face_colours.bits |= plan.faces.back().colours.bits;
  }
  if (plan.faces.empty()) {
    throw Error(ErrorCode::kInput, file + " has no faces: it is a point cloud; reconstruct a surface first");
  }
  return plan;
}

std::vector<std::string> skippedProperties(const PlyHeader& header, const PlyPlan& plan) {
  std::vector<std::string> skipped;
  const auto skip = [&](const PlyElement& element, size_t property) {
    skipped.push_back(element.name + " " + quotedText(element.properties[property].name, kShownName));
  };
  for (const PlyElement& element : header.elements) {
    if (element.count == 0) continue;
    const auto faces = std::find_if(plan.faces.begin(), plan.faces.end(),
                                    [&](const FacePlan& each) { return each.element == &element; });
    if (&element == plan.vertices.element) {
      for (size_t i = 0; i < element.properties.size(); ++i) {
        const VertexField field = plan.vertices.fields[i];
        // Texture coordinates of corners override those of vertices.
        const bool is_superseded =
            plan.corner_texture && (field == VertexField::kS || field == VertexField::kT);
        if (field == VertexField::kNone || is_superseded) skip(element, i);
      }
    } else if (faces != plan.faces.end()) {
      for (size_t i = 0; i < element.properties.size(); ++i) {
        if (faces->roles[i] == FaceRole::kSkipped) skip(element, i);
      }
    } else {
      skipped.push_back("all of " + quotedText(element.name, kShownName));
    }
  }
  return skipped;
}

VertexDefect makeVertex(const VertexPlan& plan, const VertexValues& values, PlyVertex& vertex) {
  using enum VertexField;
  const auto at = [&](VertexField field, int add) { return values[static_cast<size_t>(field) + add]; };
  vertex = {};
  const glm::dvec3 position(at(kX, 0), at(kY, 0), at(kZ, 0));
  if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z)) {
    return VertexDefect::kPosition;
  }
  vertex.position = position;
  bool finite = true, fits = true;
  const auto single = [&](VertexField field, int add) {
    const double value = at(field, add);
    const bool is_float = std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max());
    finite = finite && is_float;
    return is_float ? static_cast<float>(value) : 0.0f;
  };
  if (plan.attributes.has(AttributeSet::kNormal)) {
    for (int i = 0; i < 3; ++i) vertex.normal[i] = single(kNx, i);
  }
  if (plan.attributes.has(AttributeSet::kColour)) {
    const int channels = plan.attributes.has(AttributeSet::kAlpha) ? 4 : 3;
    for (int i = 0; i < channels; ++i) {
      const double value = at(kRed, i);
      finite = finite && std::isfinite(value);
      vertex.colour[i] = colourByte(plan.types[static_cast<size_t>(kRed) + i], value, fits);
    }
  }
  if (plan.has[static_cast<size_t>(kS)]) {
    for (int i = 0; i < 2; ++i) vertex.texture[i] = single(kS, i);
  }
  if (!finite) return VertexDefect::kAttribute;
  return fits ? VertexDefect::kNone : VertexDefect::kColour;
}

}  // namespace lode::ingest
