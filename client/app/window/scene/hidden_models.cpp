#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "client/app/window/scene/viewed_scene.h"
#include "client/core/view/framing.h"

/// Part of ViewedScene that hides models.
namespace lode::app {

bool ViewedScene::hide(size_t model_number) {
  const bool is_last = std::ranges::none_of(models_, [model_number](const auto& model) {
    return model->number != model_number && !model->instances.empty();
  });
  if (is_last || models_[model_number]->instances.empty()) return false;
  setHidden([model_number](const InstancedModel& model) {
    return model.is_hidden || model.number == model_number;
  });
  return true;
}

bool ViewedScene::isolate(size_t model_number) {
  if (scene_.is_single_model || models_[model_number]->instances.empty()) return false;
  setHidden([model_number](const InstancedModel& model) { return model.number != model_number; });
  return true;
}

void ViewedScene::showAll() {
  setHidden([](const InstancedModel&) { return false; });
}

/// Hides the models for which a function returns true, and shows all others.
void ViewedScene::setHidden(const std::function<bool(const InstancedModel&)>& is_hidden) {
  for (const auto& model : models_) {
    const bool was_hidden = std::exchange(model->is_hidden, is_hidden(*model));
    if (was_hidden == model->is_hidden) continue;
    model->renderer.release();
    model->probes.clear();
    model->status = {};
    if (model->is_hidden && model->isOpen()) rest(*model);
  }
  memory_.allowChanges();
  setUp();
}

/// Reduces a hidden model's stream to the coarsest mesh.
void ViewedScene::rest(const InstancedModel& model) {
  const ModelSummary& summary = *model.opened.model;
  const core::CameraPath path = core::framingCamera(summary);
  model.opened.streamer->setView(core::toView(path.keys.front(), path.fov_y_deg, 1, 1, summary),
                                 std::numeric_limits<float>::max());
}

std::vector<std::string> ViewedScene::hidden() const {
  std::vector<std::string> names;
  for (const auto& model : models_)
    if (model->is_hidden) names.push_back(scene_.models[model->number].name);
  return names;
}

}  // namespace lode::app
