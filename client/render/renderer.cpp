#include "client/render/renderer.h"

#include <algorithm>
#include <cstddef>

#include "client/render/eye.h"
#include "client/render/gpu_vertex.h"
#include "client/render/shader_program.h"
#include "client/render/shaders.h"

namespace lode::render {
namespace {

enum MeshUniform : GLint {
  kEyeHigh,
  kEyeLow,
  kLatticeStep,
  kViewRotation,
  kProjection,
  kUvFrame,
  kTextureCount
};
enum BackgroundUniform : GLint { kBottom, kTop };
enum Attribute : GLuint { kPositionCode, kNormal, kColour, kDrawFlags, kTextureCode };
enum Binding : GLuint { kVertices, kDraws };

GlVertexArray makeMeshArray(const GlBuffer& flags) {
  GlVertexArray array = GlVertexArray::create();
  const GLuint name = array.get();
  for (const GLuint attribute : {kPositionCode, kNormal, kColour, kDrawFlags, kTextureCode}) {
    if (attribute != kTextureCode) glEnableVertexArrayAttrib(name, attribute);
    glVertexArrayAttribBinding(name, attribute, attribute == kDrawFlags ? kDraws : kVertices);
  }
  glVertexArrayAttribIFormat(name, kPositionCode, 2, GL_UNSIGNED_INT, offsetof(GpuVertex, position_low));
  glVertexArrayAttribFormat(name, kNormal, 4, GL_INT_2_10_10_10_REV, GL_TRUE, offsetof(GpuVertex, normal));
  glVertexArrayAttribFormat(name, kColour, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(GpuVertex, colour));
  glVertexArrayAttribIFormat(name, kTextureCode, 3, GL_UNSIGNED_SHORT, offsetof(GpuTexturedVertex, texture));
  glVertexArrayAttribIFormat(name, kDrawFlags, 1, GL_UNSIGNED_INT, 0);
  glVertexArrayBindingDivisor(name, kDraws, 1);
  glVertexArrayVertexBuffer(name, kDraws, flags.get(), 0, sizeof(uint32_t));
  return array;
}

uint32_t flagsOf(const DrawItem& item, const DrawStyle& style, bool has_textures) {
  uint32_t flags = style.lod_colours ? kDrawLodColour : 0;
  if (hasNormals(item.attributes)) flags |= kDrawHasNormals;
  if (item.attributes.has(AttributeSet::kColour)) flags |= kDrawHasColour;
  if (has_textures && item.attributes.has(AttributeSet::kTexture)) flags |= kDrawTextured;
  const auto hash = static_cast<uint32_t>(item.node.value * 0x9e3779b97f4a7c15ull >> 56);
  return flags | static_cast<uint32_t>(item.node.depth()) << 8 | std::min(item.rung, 255u) << 16 | hash << 24;
}

void setFrameState(const DrawStyle& style) {
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_MULTISAMPLE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_GREATER);  // reversed: near is 1, far is 0
  glPolygonMode(GL_FRONT_AND_BACK, style.wireframe ? GL_LINE : GL_FILL);
}

}  // namespace

Renderer::Renderer(double lattice_step, const ResidencyOptions& options)
    : lattice_step_(lattice_step),
      meshes_(options),
      textures_(options.texture_budget_bytes, options.texture_staging_bytes),
      plain_program_(linkProgram(kMeshVertexShader, kMeshFragmentShader)),
      textured_program_(linkProgram(kMeshVertexShader, kMeshFragmentShader, "TEXTURED")),
      background_program_(linkProgram(kBackgroundVertexShader, kBackgroundFragmentShader)),
      empty_array_(GlVertexArray::create()),
      commands_buffer_(GlBuffer::create()),
      flags_buffer_(GlBuffer::create()) {
  mesh_array_ = makeMeshArray(flags_buffer_);
}

void Renderer::show(const std::shared_ptr<const core::Cut>& cut) {
  meshes_.show(cut);
  textures_.show(cut, meshes_.drawnCut());
}

void Renderer::uploadInRenderThread(const UploadBudget& budget) {
  UploadBudget left = budget;
  const uint64_t used_bytes = meshes_.uploadInRenderThread(budget);
  left.bytes -= static_cast<uint32_t>(std::min<uint64_t>(used_bytes, left.bytes));
  textures_.show(meshes_.newest(), meshes_.drawnCut());
  textures_.uploadInRenderThread(left);
}

uint64_t Renderer::gpuBytes() const noexcept {
  return meshes_.pages().capacityBytes() + meshes_.stagingBytes() + textures_.bytes() +
         textures_.stagingBytes();
}

void Renderer::drawBackground(const DrawStyle& style) const {
  const GLfloat far_depth = 0;
  glClearBufferfv(GL_DEPTH, 0, &far_depth);
  glDisable(GL_DEPTH_TEST);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glUseProgram(background_program_.get());
  glUniform3fv(kBottom, 1, &style.background_bottom_srgb.x);
  glUniform3fv(kTop, 1, &style.background_top_srgb.x);
  glBindVertexArray(empty_array_.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

/// Sorts what is in the picture by page.
DrawCounts Renderer::collect(const core::View& view, const DrawStyle& style) {
  DrawCounts counts;
  commands_.resize(meshes_.pages().pageCount());
  for (auto& page : commands_) page.clear();
  flags_.clear();
  for (const DrawItem& item : meshes_.drawn()) {
    if (!core::boxMayBeVisible(core::toModelBox(item.box, lattice_step_), view)) continue;
    commands_[item.page].push_back({item.index_count, 1, item.first_index,
                                    static_cast<int32_t>(item.base_vertex),
                                    static_cast<uint32_t>(flags_.size())});
    flags_.push_back(flagsOf(item, style, textures_.set() != nullptr));
    counts.triangles += item.index_count / 3;
    ++counts.nodes;
  }
  return counts;
}

/// Coordinates are told to the shader without the whole repeats in their origin, which floats would lose.
void Renderer::setTextures() const {
  const TextureSet* const set = textures_.set();
  if (set == nullptr) return;
  const glm::vec2 origin(set->uv_origin - glm::floor(set->uv_origin));
  glUniform3f(kUvFrame, origin.x, origin.y, static_cast<float>(uvStep(*set)));
  glUniform1ui(kTextureCount, static_cast<GLuint>(set->textures.size()));
  textures_.bind();
}

uint32_t Renderer::drawPages() const {
  std::vector<DrawCommand> all;
  all.reserve(flags_.size());
  for (const auto& page : commands_) all.insert(all.end(), page.begin(), page.end());
  glNamedBufferData(commands_buffer_.get(), static_cast<GLsizeiptr>(all.size() * sizeof(DrawCommand)),
                    all.data(), GL_STREAM_DRAW);
  glNamedBufferData(flags_buffer_.get(), static_cast<GLsizeiptr>(flags_.size() * sizeof(uint32_t)),
                    flags_.data(), GL_STREAM_DRAW);
  glBindVertexArray(mesh_array_.get());
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_buffer_.get());
  const AttributeSet attributes = meshes_.drawn().front().attributes;  // the model's, of all meshes
  const auto stride = static_cast<GLsizei>(vertexBytes(attributes));
  if (attributes.has(AttributeSet::kTexture)) {
    glEnableVertexArrayAttrib(mesh_array_.get(), kTextureCode);
  } else {
    glDisableVertexArrayAttrib(mesh_array_.get(), kTextureCode);
  }
  size_t first = 0;
  uint32_t calls = 0;
  for (uint32_t page = 0; page < commands_.size(); ++page) {
    if (commands_[page].empty()) continue;
    const GLuint buffer = meshes_.pages().buffer(page);
    glVertexArrayVertexBuffer(mesh_array_.get(), kVertices, buffer, 0, stride);
    glVertexArrayElementBuffer(mesh_array_.get(), buffer);
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT,
                                reinterpret_cast<const void*>(first * sizeof(DrawCommand)),
                                static_cast<GLsizei>(commands_[page].size()), sizeof(DrawCommand));
    first += commands_[page].size();
    ++calls;
  }
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
  glBindVertexArray(0);
  return calls;
}

DrawCounts Renderer::draw(const core::View& view, const Framebuffer& target, const DrawStyle& style) {
  target.bindForDrawing();
  setFrameState(style);
  drawBackground(style);
  DrawCounts counts = collect(view, style);
  if (counts.nodes == 0) return counts;

  setFrameState(style);
  glEnable(GL_DEPTH_TEST);
  const SplitEye eye = splitEye(view.eye_model, lattice_step_);
  const glm::mat3 rotation = viewRotation(view);
  const Projection projection = reversedProjection(view, lattice_step_);
  glUseProgram(textures_.set() != nullptr ? textured_program_.get() : plain_program_.get());
  glUniform3iv(kEyeHigh, 1, &eye.high.x);
  glUniform3fv(kEyeLow, 1, &eye.low.x);
  glUniform1f(kLatticeStep, static_cast<float>(lattice_step_));
  glUniformMatrix3fv(kViewRotation, 1, GL_FALSE, &rotation[0][0]);
  glUniform3f(kProjection, projection.scale.x, projection.scale.y, projection.near_model);
  setTextures();
  // What an image leaves clear is left out sample by sample, so that nothing has to be sorted.
  glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  glEnable(GL_SAMPLE_ALPHA_TO_ONE);
  counts.calls = drawPages();
  glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  glDisable(GL_SAMPLE_ALPHA_TO_ONE);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  return counts;
}

}  // namespace lode::render
