#include "client/render/renderer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "client/core/shown_parts.h"
#include "client/core/sight.h"
#include "client/render/cluster_culling.h"
#include "client/render/eye.h"
#include "client/render/gpu_vertex.h"
#include "client/render/light.h"
#include "client/render/shader_program.h"
#include "client/render/shaders.h"
#include "common/srgb.h"

namespace lode::render {
namespace {

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
  kTexelColours
};
enum BackgroundUniform : GLint { kBottom, kTop };
enum Attribute : GLuint { kPositionCode, kNormal, kColour, kDrawState, kTextureCode };
enum Binding : GLuint { kVertices, kDraws };

GlVertexArray makeMeshArray(const GlBuffer& states) {
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
  glVertexArrayVertexBuffer(name, kDraws, states.get(), 0, 3 * sizeof(uint32_t));
  return array;
}

/// In light, as shaders reckon, what is meant for a screen.
glm::vec3 toLinear(const glm::u8vec3& srgb) {
  return glm::dvec3(linearOf(srgb.r), linearOf(srgb.g), linearOf(srgb.b));
}

/// Fewer are drawn sooner than found to be hidden.
constexpr size_t kFewClusters = 64;

uint32_t in256ths(float share) { return static_cast<uint32_t>(std::lround(share * 256)); }

void setFrameState() {
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_MULTISAMPLE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_GREATER);  // reversed: near is 1, far is 0
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

}  // namespace

DrawCounts& DrawCounts::operator+=(const DrawCounts& more) noexcept {
  triangles += more.triangles;
  nodes += more.nodes;
  calls += more.calls;
  error_px = std::max(error_px, more.error_px);
  shown += more.shown;
  return *this;
}

Renderer::Renderer(double lattice_step, const ResidencyOptions& options)
    : lattice_step_(lattice_step),
      meshes_(options),
      textures_(options.texture_budget_bytes, options.texture_staging_bytes),
      background_program_(linkProgram(kBackgroundVertexShader, {kBackgroundFragmentShader})),
      empty_array_(GlVertexArray::create()),
      commands_buffer_(GlBuffer::create()),
      states_buffer_(GlBuffer::create()) {
  mesh_array_ = makeMeshArray(states_buffer_);
}

void Renderer::setMemory(const ResidencyOptions& options) {
  meshes_.setBudget(options.budget_bytes);
  meshes_.setSpare(options.spare_bytes);
  textures_.setBudget(options.texture_budget_bytes);
}

void Renderer::show(const std::shared_ptr<const core::Cut>& cut) {
  meshes_.show(cut);
  showTextures();
}

void Renderer::show(std::shared_ptr<const core::PlacedCuts> placed) {
  meshes_.show(std::move(placed));
  showTextures();
}

void Renderer::showTextures() {
  const auto all = [](const std::shared_ptr<const core::PlacedCuts>& placed) {
    return placed ? placed->all : nullptr;
  };
  textures_.show(all(meshes_.newest()), all(meshes_.before()));
}

UploadBudget Renderer::uploadInRenderThread(const UploadBudget& budget) {
  const auto start = std::chrono::steady_clock::now();
  keepWhatIsShown();
  uint64_t used_bytes = meshes_.uploadInRenderThread(budget);
  const auto left = [&] {
    UploadBudget rest = budget;
    const std::chrono::duration<double, std::milli> used = std::chrono::steady_clock::now() - start;
    rest.bytes -= static_cast<uint32_t>(std::min<uint64_t>(used_bytes, rest.bytes));
    rest.ms = std::max(0.0, rest.ms - used.count());
    return rest;
  };
  showTextures();
  used_bytes += textures_.uploadInRenderThread(left());
  return left();
}

/// So that the next picture can fade from the last.
void Renderer::keepWhatIsShown() {
  uint64_t oldest = MeshResidency::kNone;
  for (const Place& place : places_)
    if (fades_ && place.shown_serial > 0)
      oldest = std::min({oldest, place.fade.oldestSerial(), place.shown_serial});
  meshes_.keepFrom(oldest);
}

uint64_t Renderer::gpuBytes() const noexcept {
  return meshes_.pages().capacityBytes() + meshes_.stagingBytes() + textures_.bytes() +
         textures_.stagingBytes();
}

void Renderer::drawBackground(const Framebuffer& target, const DrawStyle& style) const {
  target.bindForDrawing();
  setFrameState();
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_EQUAL);
  glUseProgram(background_program_.get());
  glUniform3fv(kBottom, 1, &style.background_bottom_srgb.x);
  glUniform3fv(kTop, 1, &style.background_top_srgb.x);
  glBindVertexArray(empty_array_.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthFunc(GL_GREATER);
  glBindVertexArray(0);
}

Renderer::DrawState Renderer::stateOf(const FadedItem& faded, const DrawStyle& style,
                                      float threshold_rad) const {
  const DrawItem& item = faded.item;
  uint32_t flags = hasNormals(item.attributes) ? kDrawHasNormals : 0;
  if (item.attributes.has(AttributeSet::kColour)) flags |= kDrawHasColour;
  if (textures_.set() != nullptr && item.attributes.has(AttributeSet::kTexture)) flags |= kDrawTextured;
  if (style.show == Show::kUnlit) flags |= kDrawUnlit;
  if (style.show == Show::kNormals) flags |= kDrawNormals;
  if (style.show == Show::kTexels) flags |= kDrawTexels;
  const uint32_t share = in256ths(faded.from) | in256ths(faded.to) << 16;
  if (!coloursParts(style.show)) return {flags, glm::u8vec4(255), share};
  const glm::u8vec3 colour = colourOf(style.show, item, threshold_rad, style.place.number);
  return {flags | kDrawTinted, glm::u8vec4(colour, 255), share};
}

/// What the drawn cut shows to this camera, and what still fades.
void Renderer::choose(Place& place, size_t number, const core::View& view, const DrawTime& time) {
  if (meshes_.keptFrom() > std::min(place.fade.oldestSerial(), place.shown_serial)) place.fade.forget();
  ShownCover cover{meshes_.drawnCut(number), meshes_.drawn(number), {}, meshes_.drawnSerial()};
  std::vector<uint32_t> numbers;
  if (cover.cut) numbers = core::shownParts(*cover.cut, view);
  cover.numbers = numbers;
  place.fade.show(cover, view, lattice_step_, time);
  place.shown_serial = cover.serial;
  fades_ = time.fades;
}

void Renderer::leaveOut(size_t place) {
  if (place < places_.size()) places_[place] = {};
}

bool Renderer::fading() const noexcept {
  return std::ranges::any_of(places_, [](const Place& place) { return place.fade.fading(); });
}

bool Renderer::ageing() const noexcept {
  return std::ranges::any_of(in_picture_, [](const DrawItem& item) { return item.age_s <= kOldS; });
}

/// Finds what may be in the picture.
DrawCounts Renderer::collect(Place& place, const core::View& view, const DrawStyle& style,
                             float threshold_rad) {
  DrawCounts counts;
  place.seen.clear();
  place.states.clear();
  place.states_of_cut = 0;
  in_picture_.clear();
  const core::Sight sight(view, 1);
  size_t number = 0;
  float error_rad = 0;
  for (const FadedItem& faded : place.fade.items()) {
    const bool is_of_cut = number++ < place.fade.coverCount();
    const bool is_drawn = in256ths(faded.from) < in256ths(faded.to);
    const SeenCluster like{&faded.item, 0, static_cast<uint32_t>(place.states.size()), !faded.whole()};
    const size_t clusters = addSeenClusters(like, sight, lattice_step_, place.seen);
    if (clusters == 0) continue;
    if (is_of_cut) in_picture_.emplace_back(faded.item).place = style.place;
    if (!is_drawn) {
      place.seen.resize(place.seen.size() - clusters);
      continue;
    }
    place.states.push_back(stateOf(faded, style, threshold_rad));
    if (is_of_cut) place.states_of_cut = place.states.size();
    error_rad = std::max(error_rad, faded.item.error_rad);
    ++counts.nodes;
  }
  counts.error_px = static_cast<float>(error_rad * focalPx(view));
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

void Renderer::setCamera(const core::View& view, const DrawStyle& style) const {
  const SplitEye eye = splitEye(view.eye_model, lattice_step_);
  const glm::mat3 rotation = viewRotation(view);
  const Projection projection = reversedProjection(view, lattice_step_);
  glUniform3iv(kEyeHigh, 1, &eye.high.x);
  glUniform3fv(kEyeLow, 1, &eye.low.x);
  glUniform1f(kLatticeStep, static_cast<float>(lattice_step_));
  glUniformMatrix3fv(kViewRotation, 1, GL_FALSE, &rotation[0][0]);
  glUniform3f(kProjection, projection.scale.x, projection.scale.y, projection.near_model);
  const Light light = lightFor(view, style.up == glm::dvec3(0) ? view.up : style.up);
  glUniform3fv(kToSun, 1, &light.to_sun.x);
  glUniform3fv(kUp, 1, &light.up.x);
  glUniform1f(kExposure, style.exposure);
  if (style.show == Show::kSurface) return;
  std::array<glm::vec3, kTexelColourCount> texel_colours;
  std::ranges::transform(texelColours(), texel_colours.begin(), toLinear);
  glUniform3fv(kTexelColours, kTexelColourCount, &texel_colours[0].x);
}

/// Gives the GPU what is listed.
void Renderer::bindDraws(const Place& place) {
  std::vector<DrawCommand> all;
  for (DrawList* const list : {&whole_, &fading_}) {
    list->first = all.size();
    for (const auto& page : list->by_page) all.insert(all.end(), page.begin(), page.end());
  }
  glNamedBufferData(commands_buffer_.get(), static_cast<GLsizeiptr>(all.size() * sizeof(DrawCommand)),
                    all.data(), GL_STREAM_DRAW);
  glNamedBufferData(states_buffer_.get(), static_cast<GLsizeiptr>(place.states.size() * sizeof(DrawState)),
                    place.states.data(), GL_STREAM_DRAW);
  glBindVertexArray(mesh_array_.get());
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_buffer_.get());
}

const GlProgram& Renderer::program(bool fades, const DrawStyle& style) {
  unsigned parts = fades ? MeshPrograms::kFading : 0;
  if (textures_.set() != nullptr) parts |= MeshPrograms::kTextured;
  if (textures_.hasClear() && !has_samples_) parts |= MeshPrograms::kCutOut;
  if (style.show != Show::kSurface) parts |= MeshPrograms::kViews;
  if (style.show == Show::kWireframe) parts |= MeshPrograms::kWire;
  return programs_.with(parts);
}

/// @param attributes  the model's, of all meshes
uint32_t Renderer::drawList(const DrawList& list, AttributeSet attributes) const {
  const auto stride = static_cast<GLsizei>(vertexBytes(attributes));
  if (attributes.has(AttributeSet::kTexture)) {
    glEnableVertexArrayAttrib(mesh_array_.get(), kTextureCode);
  } else {
    glDisableVertexArrayAttrib(mesh_array_.get(), kTextureCode);
  }
  size_t first = list.first;
  uint32_t calls = 0;
  for (uint32_t page = 0; page < list.by_page.size(); ++page) {
    const size_t count = list.by_page[page].size();
    if (count == 0) continue;
    const GLuint buffer = meshes_.pages().buffer(page);
    glVertexArrayVertexBuffer(mesh_array_.get(), kVertices, buffer, 0, stride);
    glVertexArrayElementBuffer(mesh_array_.get(), buffer);
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT,
                                reinterpret_cast<const void*>(first * sizeof(DrawCommand)),
                                static_cast<GLsizei>(count), sizeof(DrawCommand));
    first += count;
    ++calls;
  }
  return calls;
}

DrawCounts Renderer::draw(const core::View& view, const Framebuffer& target, const DrawStyle& style,
                          const DrawTime& time) {
  DrawCounts counts = drawPlace(0, view, target, style, time);
  if (time.leaves_out_hidden) {
    const bool are_few = places_[0].seen.size() < kFewClusters;
    counts += drawAppeared(0, view, target, style, are_few ? FarthestDepths() : depth_reader_.read(target));
  }
  if (!style.over) drawBackground(target, style);
  return counts;
}

DrawCounts Renderer::drawPlace(size_t number, const core::View& view, const Framebuffer& target,
                               const DrawStyle& style, const DrawTime& time) {
  target.bindForDrawing();
  has_samples_ = target.samples() > 1;
  setFrameState();
  const GLfloat far_depth = 0;
  if (!style.over) glClearBufferfv(GL_DEPTH, 0, &far_depth);
  static_assert(std::is_nothrow_move_constructible_v<Place>);  // clusters point to the items of others' fades
  if (number >= places_.size()) places_.resize(number + 1);
  Place& place = places_[number];
  choose(place, number, view, time);
  const auto& cut = meshes_.drawnCut(number);
  DrawCounts counts = collect(place, view, style, cut ? static_cast<float>(thresholdRad(*cut)) : 0);
  place.is_drawn.assign(place.seen.size(), true);
  if (time.leaves_out_hidden) {
    for (size_t i = 0; i < place.seen.size(); ++i) place.is_drawn[i] = !place.seen[i].hidden(number);
  }
  drawClusters(place, place.is_drawn, view, style, counts);
  return counts;
}

DrawCounts Renderer::drawAppeared(size_t number, const core::View& view, const Framebuffer& target,
                                  const DrawStyle& style, const FarthestDepths& drawn) {
  DrawCounts counts;
  const Place& place = places_[number];
  const Occluders occluders(view, lattice_step_, drawn);
  std::vector<bool> has_appeared(place.seen.size());
  for (size_t i = 0; i < place.seen.size(); ++i) {
    const SeenCluster& cluster = place.seen[i];
    const bool is_hidden = occluders.hide(core::toModelBox(cluster.box(), lattice_step_));
    cluster.hidden(number) = is_hidden;
    has_appeared[i] = !place.is_drawn[i] && !is_hidden;
  }
  target.bindForDrawing();
  drawClusters(place, has_appeared, view, style, counts);
  return counts;
}

void Renderer::drawClusters(const Place& place, const std::vector<bool>& is_chosen, const core::View& view,
                            const DrawStyle& style, DrawCounts& counts) {
  for (DrawList* const list : {&whole_, &fading_}) list->clear(meshes_.pages().pageCount());
  const double focal_px = core::focalPx(view);
  for (size_t i = 0; i < place.seen.size(); ++i) {
    if (!is_chosen[i]) continue;
    const SeenCluster& cluster = place.seen[i];
    (cluster.fades ? fading_ : whole_).add(cluster);
    counts.triangles += cluster.triangles();
    counts.shown.drawn.add(cluster.triangles(), cluster.item->threshold_rad * focal_px);
    if (cluster.state < place.states_of_cut)
      counts.shown.complete.add(cluster.triangles(), cluster.item->complete_rad * focal_px);
  }
  if (whole_.empty() && fading_.empty()) return;
  glEnable(GL_DEPTH_TEST);
  bindDraws(place);
  // What an image leaves clear is left out sample by sample, so that nothing has to be sorted.
  if (textures_.hasClear()) {
    glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
    glEnable(GL_SAMPLE_ALPHA_TO_ONE);
  }
  const AttributeSet attributes = place.seen.front().item->attributes;
  for (const bool fades : {false, true}) {
    const DrawList& list = fades ? fading_ : whole_;
    if (list.empty()) continue;
    glUseProgram(program(fades, style).get());
    setCamera(view, style);
    setTextures();
    counts.calls += drawList(list, attributes);
  }
  glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  glDisable(GL_SAMPLE_ALPHA_TO_ONE);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
  glBindVertexArray(0);
}

}  // namespace lode::render
