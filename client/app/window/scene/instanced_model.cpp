#include "client/app/window/scene/instanced_model.h"

#include <utility>

namespace lode::app {

InstancedModel::InstancedModel(size_t model_number, std::unique_ptr<RetryingOpener> target,
                               const MemoryShares& memory)
    : number(model_number), renderer(1, memory.gpu), opener(std::move(target)) {}

bool InstancedModel::poll() {
  if (isOpen() && !opened.is_preview) return false;
  const ModelSummary* const before = opened.model;
  opened = opener->poll();
  if (opened.model == before) return false;
  renderer.setLatticeStep(opened.model->lattice.step);
  return true;
}

core::View InstancedModel::viewAt(size_t instance, const core::View& scene_view) const {
  return viewFrom(scene_view, instances[instance], opened.model->lattice.origin);
}

glm::dvec3 InstancedModel::toScene(size_t instance, const glm::dvec3& point_model) const {
  const Placement& at = instances[instance];
  const glm::dvec3 origin = at.position + at.rotation * (at.scale * opened.model->lattice.origin);
  return origin + at.rotation * (at.scale * point_model);
}

glm::dvec3 InstancedModel::toModel(size_t instance, const glm::dvec3& point_scene) const {
  const Placement& at = instances[instance];
  return glm::conjugate(at.rotation) * (point_scene - toScene(instance, glm::dvec3(0))) / at.scale;
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

}  // namespace lode::app
