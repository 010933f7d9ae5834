#include "client/render/passes/contact_shadows.h"

#include <cstddef>
#include <vector>

#include "client/render/gl/eye.h"
#include "client/render/gl/shader_program.h"

namespace lode::render {
namespace {

enum ShadowUniform : GLint { kShadowRotation, kShadowProjection };
enum ShadowAttribute : GLuint { kMiddle, kAcross, kAlong };

const char* const kVertexShader = R"glsl(
layout(location = 0) in vec4 middle_depth;  // centre relative to the eye; w is ContactShadow::depth
layout(location = 1) in vec3 across;
layout(location = 2) in vec3 along;
layout(location = 0) uniform mat3 view_rotation;
layout(location = 1) uniform vec3 projection;  // scale x, scale y and near distance
out vec2 place;
flat out float depth;

void main() {
  place = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID >> 1) * 2 - 1);
  depth = middle_depth.w;
  vec3 position_view = view_rotation * (middle_depth.xyz + place.x * across + place.y * along);
  gl_Position = vec4(projection.xy * position_view.xy, projection.z, -position_view.z);
}
)glsl";

const char* const kFragmentShader = R"glsl(
in vec2 place;
flat in float depth;
out vec4 pixel;

void main() {
  float light = 1.0 - depth * (1.0 - smoothstep(0.3, 1.0, length(place)));
  pixel = vec4(vec3(light), 1.0);
}
)glsl";

/// A shadow in the layout of the vertex shader.
struct Spot {
  glm::vec4 middle_depth;
  glm::vec3 across, along;
};

}  // namespace

ContactShadows::ContactShadows()
    : program_(linkProgram(kVertexShader, {kFragmentShader})),
      array_(GlVertexArray::create()),
      spots_(GlBuffer::create()) {
  const GLuint array = array_.get();
  glVertexArrayAttribFormat(array, kMiddle, 4, GL_FLOAT, GL_FALSE, offsetof(Spot, middle_depth));
  glVertexArrayAttribFormat(array, kAcross, 3, GL_FLOAT, GL_FALSE, offsetof(Spot, across));
  glVertexArrayAttribFormat(array, kAlong, 3, GL_FLOAT, GL_FALSE, offsetof(Spot, along));
  for (const GLuint attribute : {kMiddle, kAcross, kAlong}) {
    glEnableVertexArrayAttrib(array, attribute);
    glVertexArrayAttribBinding(array, attribute, 0);
  }
  glVertexArrayBindingDivisor(array, 0, 1);
  glVertexArrayVertexBuffer(array, 0, spots_.get(), 0, sizeof(Spot));
}

void ContactShadows::draw(std::span<const ContactShadow> shadows, const core::View& view,
                          const Framebuffer& target) {
  if (shadows.empty()) return;
  std::vector<Spot> spots;
  spots.reserve(shadows.size());
  for (const ContactShadow& shadow : shadows)
    spots.push_back({glm::vec4(shadow.middle - view.eye_model, shadow.depth), shadow.across, shadow.along});
  glNamedBufferData(spots_.get(), static_cast<GLsizeiptr>(spots.size() * sizeof(Spot)), spots.data(),
                    GL_STREAM_DRAW);
  const glm::mat3 rotation = viewRotation(view);
  const Projection projection = reversedProjection(view, view.near_model);
  target.bindForDrawing();
  glUseProgram(program_.get());
  glUniformMatrix3fv(kShadowRotation, 1, GL_FALSE, &rotation[0][0]);
  glUniform3f(kShadowProjection, projection.scale.x, projection.scale.y, projection.near_model);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ZERO, GL_SRC_COLOR);
  glBindVertexArray(array_.get());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(spots.size()));
  glBindVertexArray(0);
  glDisable(GL_BLEND);
}

}  // namespace lode::render
