#include "client/render/renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <type_traits>

#include "client/core/shown_parts.h"
#include "client/core/sight.h"
#include "client/render/cluster_culling.h"
#include "client/render/gpu_vertex.h"
#include "client/render/shader_program.h"
#include "client/render/shaders.h"

namespace lode::render {
namespace {

enum BackgroundUniform : GLint { kBottom, kTop };

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

DrawState Renderer::stateOf(const FadedItem& faded, const DrawStyle& style, float threshold_rad) const {
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
Renderer::Place& Renderer::choose(size_t number, const core::View& view, const DrawTime& time) {
  static_assert(std::is_nothrow_move_constructible_v<Place>);  // clusters point to the items of others' fades
  if (number >= places_.size()) places_.resize(number + 1);
  Place& place = places_[number];
  if (meshes_.keptFrom() > std::min(place.fade.oldestSerial(), place.shown_serial)) place.fade.forget();
  ShownCover cover{meshes_.drawnCut(number), meshes_.drawn(number), {}, meshes_.drawnSerial()};
  std::vector<uint32_t> numbers;
  if (cover.cut) numbers = core::shownParts(*cover.cut, view);
  cover.numbers = numbers;
  place.fade.show(cover, view, lattice_step_, time);
  place.shown_serial = cover.serial;
  fades_ = time.fades;
  return place;
}

void Renderer::leaveOut(size_t place) {
  if (place < places_.size()) places_[place] = {};
}

bool Renderer::fading() const noexcept {
  return std::ranges::any_of(places_, [](const Place& place) { return place.fade.fading(); });
}

bool Renderer::ageing() const noexcept {
  return std::ranges::any_of(places_, [](const Place& place) {
    return std::ranges::any_of(place.in_picture, [](const DrawItem& item) { return item.age_s <= kOldS; });
  });
}

/// Finds what may be in the picture: parts where the GPU finds their clusters, else these.
DrawCounts Renderer::collect(Place& place, const core::View& view, const DrawStyle& style,
                             bool is_found_on_gpu) {
  DrawCounts counts;
  place.seen.clear();
  place.parts.clear();
  place.states.clear();
  place.states_of_cut = 0;
  place.in_picture.clear();
  const core::Sight sight(view, 1);
  const auto& cut = place.fade.cut();
  const float threshold_rad = cut ? static_cast<float>(thresholdRad(*cut)) : 0;
  size_t number = 0;
  float error_rad = 0;
  for (const FadedItem& faded : place.fade.items()) {
    const bool is_of_cut = number++ < place.fade.coverCount();
    const bool is_drawn = in256ths(faded.from) < in256ths(faded.to);
    const SeenPart part{&faded.item, static_cast<uint32_t>(place.states.size()), !faded.whole()};
    const size_t before = place.seen.size();
    if (is_found_on_gpu ? !isInPicture(part, sight, lattice_step_)
                        : addSeenClusters(part, sight, lattice_step_, place.seen) == 0)
      continue;
    if (is_of_cut) place.in_picture.emplace_back(faded.item).place = style.place;
    if (!is_drawn) {
      place.seen.resize(before);
      continue;
    }
    if (is_found_on_gpu) place.parts.push_back(part);
    place.states.push_back(stateOf(faded, style, threshold_rad));
    if (is_of_cut) place.states_of_cut = place.states.size();
    error_rad = std::max(error_rad, faded.item.error_rad);
    ++counts.nodes;
  }
  if (!place.states_buffer) place.states_buffer = GlBuffer::create();
  glNamedBufferData(place.states_buffer.get(),
                    static_cast<GLsizeiptr>(place.states.size() * sizeof(DrawState)), place.states.data(),
                    GL_STREAM_DRAW);
  counts.error_px = static_cast<float>(error_rad * focalPx(view));
  return counts;
}

DrawCounts Renderer::draw(const core::View& view, const Framebuffer& target, const DrawStyle& style,
                          const DrawTime& time) {
  const Placement alone{this, 0, view, style};
  const DrawCounts counts = placement_drawer_.draw({&alone, 1}, target, time);
  if (!style.over) drawBackground(target, style);
  return counts;
}

DrawCounts Renderer::drawPlace(size_t number, const core::View& view, const Framebuffer& target,
                               const DrawStyle& style, const DrawTime& time) {
  startPicture(target, style);
  has_samples_ = target.samples() > 1;
  Place& place = choose(number, view, time);
  DrawCounts counts = collect(place, view, style, false);
  place.last_view.reset();
  place.is_drawn.assign(place.seen.size(), true);
  if (time.hidden_parts == HiddenParts::kReadBack) {
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
  for (size_t i = 0; i < place.seen.size(); ++i) {
    if (!is_chosen[i]) continue;
    const SeenCluster& cluster = place.seen[i];
    (cluster.part.fades ? fading_ : whole_).add(cluster);
    counts.triangles += cluster.triangles();
    countShown(place, cluster.part, cluster.triangles(), view, counts);
  }
  if (whole_.empty() && fading_.empty()) return;
  giveCommands();
  drawer_.begin(place.states_buffer, place.seen.front().part.item->attributes, textures_);
  for (const bool fades : {false, true}) {
    const DrawList& list = fades ? fading_ : whole_;
    if (list.empty()) continue;
    drawer_.use(fades, has_samples_, view, lattice_step_, style);
    counts.calls += drawList(list);
  }
  drawer_.end();
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
}

/// Adds what triangles of a part say of the thresholds of a picture.
void Renderer::countShown(const Place& place, const SeenPart& part, uint32_t triangles,
                          const core::View& view, DrawCounts& counts) {
  const double focal_px = core::focalPx(view);
  counts.shown.drawn.add(triangles, part.item->threshold_rad * focal_px);
  if (part.state < place.states_of_cut)
    counts.shown.complete.add(triangles, part.item->complete_rad * focal_px);
}

/// Gives the GPU what is listed.
void Renderer::giveCommands() {
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

}  // namespace lode::render
