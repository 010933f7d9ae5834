#include "client/render/renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <type_traits>

#include "client/core/lod/cut.h"
#include "client/core/view/view.h"
#include "client/render/culling/cluster_culling.h"
#include "client/render/gl/shader_program.h"
#include "client/render/passes/mesh_shaders.h"
#include "client/render/residency/gpu_vertex.h"

namespace lode::render {
namespace {

enum BackgroundUniform : GLint { kBottom, kTop };

const char* const kBackgroundVertexShader = R"glsl(
out float height;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  height = corner.y * 0.5 + 0.5;
  gl_Position = vec4(corner, 0.0, 1.0);
}
)glsl";

const char* const kBackgroundFragmentShader = R"glsl(
in float height;
out vec4 pixel;
layout(location = 0) uniform vec3 bottom_srgb;
layout(location = 1) uniform vec3 top_srgb;

vec3 toLinear(vec3 srgb) {
  return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), greaterThan(srgb, vec3(0.04045)));
}

void main() {
  // Add noise of up to half a colour step, to hide the bands of a shallow gradient. Source: Jimenez, Next
  // Generation Post-Processing in Call of Duty: Advanced Warfare, 2014 (interleaved gradient noise).
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  vec3 srgb = mix(bottom_srgb, top_srgb, height);
  if (bottom_srgb != top_srgb) srgb += noise / 255.0;
  pixel = vec4(toLinear(srgb), 1.0);
}
)glsl";

uint32_t in256ths(float share) { return static_cast<uint32_t>(std::lround(share * 256)); }

}  // namespace

Renderer::Renderer(double lattice_step, const ResidencyOptions& options)
    : lattice_step_(lattice_step),
      meshes_(options),
      textures_(options.texture_budget_bytes, options.texture_staging_bytes),
      background_program_(linkProgram(kBackgroundVertexShader, {kBackgroundFragmentShader})),
      empty_array_(GlVertexArray::create()),
      commands_buffer_(GlBuffer::create()) {}

void Renderer::setMemory(const ResidencyOptions& options) {
  meshes_.setBudget(options.budget_bytes);
  meshes_.setSpare(options.spare_bytes);
  textures_.setBudget(options.texture_budget_bytes);
}

void Renderer::show(const std::shared_ptr<const core::Cut>& cut) {
  meshes_.show(cut);
  showTextures();
}

void Renderer::show(std::shared_ptr<const core::ViewCuts> view_cuts) {
  meshes_.show(std::move(view_cuts));
  showTextures();
}

void Renderer::release() {
  instances_.clear();
  meshes_.release();
  textures_.release();
}

void Renderer::showTextures() {
  const auto all = [](const std::shared_ptr<const core::ViewCuts>& view_cuts) {
    return view_cuts ? view_cuts->all : nullptr;
  };
  textures_.show(all(meshes_.newest()), all(meshes_.before()));
}

UploadBudget Renderer::uploadInRenderThread(const UploadBudget& budget) {
  const auto start = std::chrono::steady_clock::now();
  keepShownMeshes();
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

/// Keeps the meshes of the last picture, so that the next picture can fade from them.
void Renderer::keepShownMeshes() {
  uint64_t oldest = MeshResidency::kNone;
  for (const DrawnInstance& instance : instances_)
    if (fades_ && instance.shown_serial > 0)
      oldest = std::min({oldest, instance.fade.oldestSerial(), instance.shown_serial});
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

DrawState Renderer::stateOf(const FadedItem& faded, const DrawStyle& style, float threshold_rad) const {
  const DrawItem& item = faded.item;
  uint32_t flags = hasNormals(item.attributes) ? kDrawHasNormals : 0;
  if (item.attributes.has(AttributeSet::kColour)) flags |= kDrawHasColour;
  if (textures_.set() != nullptr && item.attributes.has(AttributeSet::kTexture)) flags |= kDrawTextured;
  const ColorModeTraits& mode = traitsOf(style.show);
  flags |= mode.draw_flags;
  const uint32_t share = in256ths(faded.from) | in256ths(faded.to) << 16;
  if (mode.colour == nullptr) return {flags, glm::u8vec4(255), share};
  const glm::u8vec3 colour = mode.colour(item, threshold_rad, style.instance.number);
  return {flags | kDrawTinted, glm::u8vec4(colour, 255), share};
}

/// Updates an instance's cross-fade with the parts that the drawn cut shows to this camera.
Renderer::DrawnInstance& Renderer::choose(size_t number, const core::View& view, const DrawTime& time) {
  // The clusters of an instance point into CrossFade::items(), so resize() must move instances, not copy
  // them.
  static_assert(std::is_nothrow_move_constructible_v<DrawnInstance>);
  if (number >= instances_.size()) instances_.resize(number + 1);
  DrawnInstance& instance = instances_[number];
  if (meshes_.keptFrom() > std::min(instance.fade.oldestSerial(), instance.shown_serial))
    instance.fade.forget();
  ShownCover cover{meshes_.drawnCut(number), meshes_.drawn(number), {}, meshes_.drawnSerial()};
  std::vector<uint32_t> numbers;
  if (cover.cut) numbers = core::shownParts(*cover.cut, view);
  cover.numbers = numbers;
  instance.fade.show(cover, view, lattice_step_, time);
  instance.shown_serial = cover.serial;
  fades_ = time.fades;
  return instance;
}

void Renderer::leaveOut(size_t instance) {
  if (instance < instances_.size()) instances_[instance] = {};
}

bool Renderer::fading() const noexcept {
  return std::ranges::any_of(instances_,
                             [](const DrawnInstance& instance) { return instance.fade.fading(); });
}

bool Renderer::ageing() const noexcept {
  return std::ranges::any_of(instances_, [](const DrawnInstance& instance) {
    return std::ranges::any_of(instance.in_picture, [](const DrawItem& item) { return item.age_s <= kOldS; });
  });
}

/// Collects the parts in the view if the GPU culls clusters, else the clusters in the view.
DrawCounts Renderer::collect(DrawnInstance& instance, const core::View& view, const DrawStyle& style,
                             bool is_found_on_gpu) {
  DrawCounts counts;
  instance.seen.clear();
  instance.parts.clear();
  instance.states.clear();
  instance.states_of_cut = 0;
  instance.in_picture.clear();
  const core::ViewFrustum frustum(view, 1);
  const auto& cut = instance.fade.cut();
  const float threshold_rad = cut ? static_cast<float>(thresholdRad(*cut)) : 0;
  size_t number = 0;
  float error_rad = 0;
  for (const FadedItem& faded : instance.fade.items()) {
    const bool is_of_cut = number++ < instance.fade.coverCount();
    const bool is_drawn = in256ths(faded.from) < in256ths(faded.to);
    const SeenPart part{&faded.item, static_cast<uint32_t>(instance.states.size()), !faded.whole()};
    const size_t before = instance.seen.size();
    if (is_found_on_gpu ? !isInPicture(part, frustum, lattice_step_)
                        : addSeenClusters(part, frustum, lattice_step_, instance.seen) == 0)
      continue;
    if (is_of_cut) instance.in_picture.emplace_back(faded.item).instance = style.instance;
    if (!is_drawn) {
      instance.seen.resize(before);
      continue;
    }
    if (is_found_on_gpu) instance.parts.push_back(part);
    instance.states.push_back(stateOf(faded, style, threshold_rad));
    if (is_of_cut) instance.states_of_cut = instance.states.size();
    error_rad = std::max(error_rad, faded.item.error_rad);
    ++counts.nodes;
  }
  if (!instance.states_buffer) instance.states_buffer = GlBuffer::create();
  glNamedBufferData(instance.states_buffer.get(),
                    static_cast<GLsizeiptr>(instance.states.size() * sizeof(DrawState)),
                    instance.states.data(), GL_STREAM_DRAW);
  counts.error_px = static_cast<float>(error_rad * focalPx(view));
  return counts;
}

DrawCounts Renderer::draw(const core::View& view, const Framebuffer& target, const DrawStyle& style,
                          const DrawTime& time) {
  const InstanceDraw alone{this, 0, view, style};
  const DrawCounts counts = instance_drawer_.draw({&alone, 1}, target, time);
  if (!style.over) drawBackground(target, style);
  return counts;
}

DrawCounts Renderer::drawInstance(size_t number, const core::View& view, const Framebuffer& target,
                                  const DrawStyle& style, const DrawTime& time) {
  startPicture(target, style);
  has_samples_ = target.samples() > 1;
  DrawnInstance& instance = choose(number, view, time);
  DrawCounts counts = collect(instance, view, style, false);
  instance.last_view.reset();
  instance.is_drawn.assign(instance.seen.size(), true);
  if (time.occlusion_culling == OcclusionCulling::kReadBack) {
    for (size_t i = 0; i < instance.seen.size(); ++i) instance.is_drawn[i] = !instance.seen[i].hidden(number);
  }
  drawClusters(instance, instance.is_drawn, view, style, counts);
  return counts;
}

DrawCounts Renderer::drawAppeared(size_t number, const core::View& view, const Framebuffer& target,
                                  const DrawStyle& style, const FarthestDepths& drawn) {
  DrawCounts counts;
  const DrawnInstance& instance = instances_[number];
  const Occluders occluders(view, lattice_step_, drawn);
  std::vector<bool> has_appeared(instance.seen.size());
  for (size_t i = 0; i < instance.seen.size(); ++i) {
    const SeenCluster& cluster = instance.seen[i];
    const bool is_hidden = occluders.hide(core::toModelBox(cluster.box(), lattice_step_));
    cluster.hidden(number) = is_hidden;
    has_appeared[i] = !instance.is_drawn[i] && !is_hidden;
  }
  target.bindForDrawing();
  drawClusters(instance, has_appeared, view, style, counts);
  return counts;
}

void Renderer::drawClusters(const DrawnInstance& instance, const std::vector<bool>& is_chosen,
                            const core::View& view, const DrawStyle& style, DrawCounts& counts) {
  for (DrawList* const list : {&whole_, &fading_}) list->clear(meshes_.pages().pageCount());
  for (size_t i = 0; i < instance.seen.size(); ++i) {
    if (!is_chosen[i]) continue;
    const SeenCluster& cluster = instance.seen[i];
    (cluster.part.fades ? fading_ : whole_).add(cluster);
    counts.triangles += cluster.triangles();
    countShown(instance, cluster.part, cluster.triangles(), view, counts);
  }
  if (whole_.empty() && fading_.empty()) return;
  uploadCommands();
  drawer_.begin(instance.states_buffer, instance.seen.front().part.item->attributes, textures_);
  for (const bool fades : {false, true}) {
    const DrawList& list = fades ? fading_ : whole_;
    if (list.empty()) continue;
    drawer_.use(fades, has_samples_, view, lattice_step_, style);
    counts.calls += drawList(list);
  }
  drawer_.end();
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

/// Adds a part's threshold, weighted by the triangles drawn, to the picture's mean thresholds.
void Renderer::countShown(const DrawnInstance& instance, const SeenPart& part, uint32_t triangles,
                          const core::View& view, DrawCounts& counts) {
  const double focal_px = core::focalPx(view);
  counts.shown.drawn.add(triangles, part.item->threshold_rad * focal_px);
  if (part.state < instance.states_of_cut)
    counts.shown.complete.add(triangles, part.item->complete_rad * focal_px);
}

/// Uploads the draw commands of both lists.
void Renderer::uploadCommands() {
  std::vector<DrawCommand> all;
  for (DrawList* const list : {&whole_, &fading_}) {
    list->first = all.size();
    for (const auto& page : list->by_page) all.insert(all.end(), page.begin(), page.end());
  }
  glNamedBufferData(commands_buffer_.get(), static_cast<GLsizeiptr>(all.size() * sizeof(DrawCommand)),
                    all.data(), GL_STREAM_DRAW);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_buffer_.get());
}

uint32_t Renderer::drawList(const DrawList& list) const {
  size_t first = list.first;
  uint32_t calls = 0;
  for (uint32_t page = 0; page < list.by_page.size(); ++page) {
    const size_t count = list.by_page[page].size();
    if (count == 0) continue;
    drawer_.bindPage(meshes_.pages(), page);
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT,
                                reinterpret_cast<const void*>(first * sizeof(DrawCommand)),
                                static_cast<GLsizei>(count), sizeof(DrawCommand));
    first += count;
    ++calls;
  }
  return calls;
}

DrawCounts Renderer::addInstance(size_t number, const core::View& view, const DrawStyle& style,
                                 const DrawTime& time, GpuCulling& culling) {
  DrawnInstance& instance = choose(number, view, time);
  DrawCounts counts = collect(instance, view, style, true);
  for (const SeenPart& part : instance.parts)
    countShown(instance, part, part.item->index_count / 3, view, counts);
  instance.number = culling.add(instance.parts, meshes_.pages(), lattice_step_, view, instance.last_view);
  instance.last_view = view;
  return counts;
}

uint32_t Renderer::drawFound(size_t number, const core::View& view, const Framebuffer& target,
                             const DrawStyle& style, const GpuCulling& culling) {
  const DrawnInstance& instance = instances_[number];
  const std::span<const GpuCulling::Draw> draws = culling.draws(instance.number);
  if (draws.empty()) return 0;
  has_samples_ = target.samples() > 1;
  drawer_.begin(instance.states_buffer, instance.parts.front().item->attributes, textures_);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, culling.commands());
  glBindBuffer(GL_PARAMETER_BUFFER, culling.counts());
  std::optional<bool> fades;
  for (const GpuCulling::Draw& draw : draws) {
    if (fades != draw.fades) drawer_.use(draw.fades, has_samples_, view, lattice_step_, style);
    fades = draw.fades;
    drawer_.bindPage(meshes_.pages(), draw.page);
    const uint64_t first = culling.firstCommandOfPass() + draw.first_command;
    const uint64_t count = culling.firstCountOfPass() + draw.count;
    glMultiDrawElementsIndirectCount(GL_TRIANGLES, GL_UNSIGNED_INT,
                                     reinterpret_cast<const void*>(first * sizeof(DrawCommand)),
                                     static_cast<GLintptr>(count * sizeof(uint32_t)),
                                     static_cast<GLsizei>(draw.most_commands), sizeof(DrawCommand));
  }
  glBindBuffer(GL_PARAMETER_BUFFER, 0);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
  drawer_.end();
  return static_cast<uint32_t>(draws.size());
}

}  // namespace lode::render
