#include "client/render/passes/mesh_drawer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "client/render/gl/eye.h"
#include "client/render/gl/shader_program.h"
#include "client/render/passes/light.h"
#include "client/render/passes/mesh_shaders.h"
#include "client/render/residency/gpu_vertex.h"
#include "common/image/image.h"

namespace lode::render {
namespace {

constexpr std::array<std::pair<MeshPrograms::Part, std::string_view>, 6> kDefinitions{
    {{MeshPrograms::kFading, "FADING"},
     {MeshPrograms::kTextured, "TEXTURED"},
     {MeshPrograms::kCutOut, "CUT_OUT"},
     {MeshPrograms::kViews, "VIEWS"},
     {MeshPrograms::kWire, "WIRE"},
     {MeshPrograms::kSection, "SECTION"}}};

static_assert(sizeof(DrawState) == 3 * sizeof(uint32_t));

enum MeshUniform : GLint {
  kEyeHigh,
  kEyeLow,
  kLatticeStep,
  kViewRotation,
  kProjection,
  kUvFrame,
  kTextureCount,
  kToSun,
  kUp,
  kExposure,
  kTexelColours,
  kSectionPlane = kTexelColours + kTexelColourCount,
  kCapColour
};
enum Attribute : GLuint { kPositionCode, kNormal, kColour, kDrawState, kTextureCode };
enum Binding : GLuint { kVertices, kDraws };

GlVertexArray makeMeshArray() {
  GlVertexArray array = GlVertexArray::create();
  const GLuint name = array.get();
  for (const GLuint attribute : {kPositionCode, kNormal, kColour, kDrawState, kTextureCode}) {
    if (attribute != kTextureCode) glEnableVertexArrayAttrib(name, attribute);
    glVertexArrayAttribBinding(name, attribute, attribute == kDrawState ? kDraws : kVertices);
  }
  glVertexArrayAttribIFormat(name, kPositionCode, 2, GL_UNSIGNED_INT, offsetof(GpuVertex, position_low));
  glVertexArrayAttribFormat(name, kNormal, 4, GL_INT_2_10_10_10_REV, GL_TRUE, offsetof(GpuVertex, normal));
  glVertexArrayAttribFormat(name, kColour, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(GpuVertex, colour));
  glVertexArrayAttribIFormat(name, kTextureCode, 3, GL_UNSIGNED_SHORT, offsetof(GpuTexturedVertex, texture));
  glVertexArrayAttribIFormat(name, kDrawState, 3, GL_UNSIGNED_INT, 0);
  glVertexArrayBindingDivisor(name, kDraws, 1);
  return array;
}

/// Converts an sRGB colour to linear light, because shaders compute in linear light.
glm::vec3 toLinear(const glm::u8vec3& srgb) {
  return glm::dvec3(linearOf(srgb.r), linearOf(srgb.g), linearOf(srgb.b));
}

}  // namespace

MeshPrograms::MeshPrograms() { with(0); }

const GlProgram& MeshPrograms::with(unsigned parts) {
  GlProgram& program = programs_.at(parts);
  if (program) return program;
  std::vector<std::string_view> definitions{(parts & kViews) != 0 ? kTintedCorner : kCorner};
  for (const auto& [part, definition] : kDefinitions)
    if ((parts & part) != 0) definitions.push_back(definition);
  program = linkProgram(kMeshVertexShader, {kLightShader, kWireShader, kMeshFragmentShader}, definitions,
                        (parts & kWire) != 0 ? kWireGeometryShader : nullptr);
  return program;
}

void setFrameState() {
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_MULTISAMPLE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_GREATER);  // depth is reversed: 1 is near, 0 is far
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

void continuePicture(const Framebuffer& target) {
  target.bindForDrawing();
  setFrameState();
}

void startPicture(const Framebuffer& target, const DrawStyle& style) {
  continuePicture(target);
  const GLfloat far_depth = 0;
  if (!style.over) glClearBufferfv(GL_DEPTH, 0, &far_depth);
}

MeshDrawer::MeshDrawer() : array_(makeMeshArray()) {}

void MeshDrawer::begin(const GlBuffer& states, AttributeSet attributes, const TextureResidency& textures) {
  // Link the program for fading with the second picture, so that it neither delays the first nor a fade.
  if (std::exchange(has_begun_, true)) programs_.with(MeshPrograms::kFading);
  attributes_ = attributes;
  textures_ = &textures;
  glVertexArrayVertexBuffer(array_.get(), kDraws, states.get(), 0, sizeof(DrawState));
  glEnable(GL_DEPTH_TEST);
  glBindVertexArray(array_.get());
  if (attributes.has(AttributeSet::kTexture)) {
    glEnableVertexArrayAttrib(array_.get(), kTextureCode);
  } else {
    glDisableVertexArrayAttrib(array_.get(), kTextureCode);
  }
  // Use alpha to coverage, which draws transparent texels without sorting.
  if (textures.hasClear()) {
    glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
    glEnable(GL_SAMPLE_ALPHA_TO_ONE);
  }
}

void MeshDrawer::use(bool fades, bool has_samples, const core::View& view, double lattice_step,
                     const DrawStyle& style) {
  unsigned parts = fades ? MeshPrograms::kFading : 0;
  if (textures_->set() != nullptr) parts |= MeshPrograms::kTextured;
  if (textures_->hasClear() && !has_samples) parts |= MeshPrograms::kCutOut;
  if (style.show != ColorMode::kSurface) parts |= MeshPrograms::kViews;
  if (style.show == ColorMode::kWireframe) parts |= MeshPrograms::kWire;
  if (style.section) {
    parts |= MeshPrograms::kSection;
    glEnable(GL_CLIP_DISTANCE0);
  }
  glUseProgram(programs_.with(parts).get());
  setCamera(view, lattice_step, style);
  setTextures();
}

void MeshDrawer::bindPage(const GpuPages& pages, uint32_t page) const {
  const GLuint buffer = pages.buffer(page);
  glVertexArrayVertexBuffer(array_.get(), kVertices, buffer, 0,
                            static_cast<GLsizei>(vertexBytes(attributes_)));
  glVertexArrayElementBuffer(array_.get(), buffer);
}

void MeshDrawer::end() const {
  glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  glDisable(GL_SAMPLE_ALPHA_TO_ONE);
  glDisable(GL_CLIP_DISTANCE0);
  glBindVertexArray(0);
}

/// Sets the uniforms of textures. Passes only the fractional part of the texture origin: whole repeats would
/// cost float precision.
void MeshDrawer::setTextures() const {
  const TextureSet* const set = textures_->set();
  if (set == nullptr) return;
  const glm::vec2 origin(set->uv_origin - glm::floor(set->uv_origin));
  glUniform3f(kUvFrame, origin.x, origin.y, static_cast<float>(uvStep(*set)));
  glUniform1ui(kTextureCount, static_cast<GLuint>(set->textures.size()));
  textures_->bind();
}

void MeshDrawer::setCamera(const core::View& view, double lattice_step, const DrawStyle& style) const {
  const SplitEye eye = splitEye(view.eye_model, lattice_step);
  const glm::mat3 rotation = viewRotation(view);
  const Projection projection = reversedProjection(view, lattice_step);
  glUniform3iv(kEyeHigh, 1, &eye.high.x);
  glUniform3fv(kEyeLow, 1, &eye.low.x);
  glUniform1f(kLatticeStep, static_cast<float>(lattice_step));
  glUniformMatrix3fv(kViewRotation, 1, GL_FALSE, &rotation[0][0]);
  glUniform3f(kProjection, projection.scale.x, projection.scale.y, projection.near_model);
  const Light light = lightFor(view, style.up == glm::dvec3(0) ? view.up : style.up, style.sun_turn_rad);
  glUniform3fv(kToSun, 1, &light.to_sun.x);
  glUniform3fv(kUp, 1, &light.up.x);
  glUniform1f(kExposure, style.exposure);
  if (const auto& section = style.section) {
    const glm::vec3 normal = rotation * glm::vec3(section->normal);
    const auto beyond = static_cast<float>(section->offset_model - glm::dot(section->normal, view.eye_model));
    glUniform4f(kSectionPlane, normal.x, normal.y, normal.z, beyond);
    glUniform3fv(kCapColour, 1, &section->cap_srgb.x);
  }
  if (style.show == ColorMode::kSurface) return;
  std::array<glm::vec3, kTexelColourCount> texel_colours;
  std::ranges::transform(texelColours(), texel_colours.begin(), toLinear);
  glUniform3fv(kTexelColours, kTexelColourCount, &texel_colours[0].x);
}

}  // namespace lode::render
