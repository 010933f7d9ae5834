#include "client/app/window/scene/instanced_model.h"

#include <cstdint>
#include <utility>

#include "client/app/window/scene/scene_stage.h"

namespace lode::app {
namespace {

stream::StreamOptions streamOptionsOf(stream::StreamOptions options, const render::MemoryShares& memory) {
  options.engine.memory_budget_bytes = memory.stream_bytes;
  options.engine.refine.drawn_budget_bytes = memory.drawn_bytes;
  options.engine.refine.hysteresis_factor = core::kHysteresisFactor;
  options.engine.refine.shares_memory = true;
  options.engine.session.awaits_model = true;
  return options;
}

}  // namespace

InstancedModel::InstancedModel(size_t model_number, const std::string& target, stream::StreamOptions options,
                               std::chrono::milliseconds timeout, const render::MemoryShares& memory)
    : number(model_number),
      renderer(1, memory.gpu),
      opener(target, streamOptionsOf(std::move(options), memory), timeout) {}

bool InstancedModel::look() {
  if (isOpen()) return false;
  opened = opener.look();
  if (isOpen()) renderer.setLatticeStep(opened.model->lattice.step);
  return isOpen();
}

core::View InstancedModel::viewAt(size_t instance, const core::View& scene_view) const {
  return viewFrom(scene_view, instances[instance], opened.model->lattice.origin);
}

glm::dvec3 InstancedModel::toScene(size_t instance, const glm::dvec3& point_model) const {
  const Placement& at = instances[instance];
  return at.position + at.rotation * (at.scale * (opened.model->lattice.origin + point_model));
}

const core::CutProbe* InstancedModel::probe(size_t instance) {
  const auto& drawn = renderer.meshes().drawnCut(instance);
  if (!drawn) return nullptr;
  probes.resize(instances.size());
  std::optional<core::CutProbe>& probe = probes[instance];
  if (!probe || probe->cut() != drawn) probe.emplace(drawn, opened.model->lattice.step);
  return &*probe;
}

void InstancedModel::dropOldProbes() {
  for (size_t instance = 0; instance < probes.size(); ++instance)
    if (auto& probe = probes[instance]; probe && probe->cut() != renderer.meshes().drawnCut(instance))
      probe.reset();
}

render::DrawStyle InstancedModel::styleAt(size_t instance, render::DrawStyle style,
                                          const glm::dvec3& scene_up) const {
  style.up = glm::conjugate(instances[instance].rotation) * scene_up;
  style.instance = {instanceNumber(number, instance), opened.model->name,
                    static_cast<uint32_t>(instance + 1)};
  return style;
}

}  // namespace lode::app
