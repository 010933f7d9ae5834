#include "client/app/window/placed_model.h"

#include <cstdint>
#include <utility>

#include "client/app/window/scene_stage.h"

namespace lode::app {
namespace {

stream::StreamOptions streamOptionsOf(stream::StreamOptions options, const render::MemoryShares& memory) {
  options.memory_budget_bytes = memory.stream_bytes;
  options.drawn_budget_bytes = memory.drawn_bytes;
  options.hold_factor = core::kHoldFactor;
  options.shares_memory = true;
  options.awaits_model = true;
  return options;
}

}  // namespace

PlacedModel::PlacedModel(size_t model_number, const std::string& target, stream::StreamOptions options,
                         std::chrono::milliseconds timeout, const render::MemoryShares& memory)
    : number(model_number),
      renderer(1, memory.gpu),
      opener(target, streamOptionsOf(std::move(options), memory), timeout) {}

bool PlacedModel::look() {
  if (isOpen()) return false;
  opened = opener.look();
  if (isOpen()) renderer.setLatticeStep(opened.model->lattice.step);
  return isOpen();
}

core::View PlacedModel::viewAt(size_t place, const core::View& scene_view) const {
  return viewFrom(scene_view, places[place], opened.model->lattice.origin);
}

glm::dvec3 PlacedModel::toScene(size_t place, const glm::dvec3& point_model) const {
  const Placement& at = places[place];
  return at.position + at.rotation * (at.scale * (opened.model->lattice.origin + point_model));
}

const core::CutProbe* PlacedModel::probe(size_t place) {
  const auto& drawn = renderer.meshes().drawnCut(place);
  if (!drawn) return nullptr;
  probes.resize(places.size());
  std::optional<core::CutProbe>& probe = probes[place];
  if (!probe || probe->cut() != drawn) probe.emplace(drawn, opened.model->lattice.step);
  return &*probe;
}

void PlacedModel::dropOldProbes() {
  for (size_t place = 0; place < probes.size(); ++place)
    if (auto& probe = probes[place]; probe && probe->cut() != renderer.meshes().drawnCut(place))
      probe.reset();
}

render::DrawStyle PlacedModel::styleAt(size_t place, render::DrawStyle style,
                                       const glm::dvec3& scene_up) const {
  style.up = glm::conjugate(places[place].rotation) * scene_up;
  style.place = {placeNumber(number, place), opened.model->name, static_cast<uint32_t>(place + 1)};
  return style;
}

}  // namespace lode::app
