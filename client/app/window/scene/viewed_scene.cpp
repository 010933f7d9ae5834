#include "client/app/window/scene/viewed_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "client/app/cli/first_camera.h"
#include "client/app/window/camera/ground_below.h"
#include "client/app/window/memory_shares.h"
#include "client/app/window/scene/scene_frame.h"
#include "client/app/window/scene/scene_status.h"
#include "client/core/lod/cut.h"

namespace lode::app {
namespace {

/// Says at once what is wrong with the targets of the scene's models. @throws Error.
void refuseWrongTargets(const Scene& scene, const std::string& source, Lacking lacking) {
  std::vector<std::optional<Error>> refused;
  for (const SceneModel& model : scene.models) {
    refused.emplace_back();
    try {
      parseTarget(model.target);
    } catch (const Error& error) {
      refused.back() = ofSceneModel(error, source, model);
      if (lacking == Lacking::kRefused || error.code() == ErrorCode::kUsage) throw *refused.back();
    }
  }
  if (std::ranges::all_of(scene.instances, [&refused](const SceneInstance& instance) {
        return refused[instance.model].has_value();
      }))
    throw *refused[scene.instances.front().model];
}

}  // namespace

ViewedScene::ViewedScene(const CommonOptions& options, Lacking lacking)
    : scene_(readScene(options.target)),
      options_(options),
      lacking_(lacking),
      framing_(framingOf(scene_, options)),
      memory_(options.streamOptions().engine.memory_budget_bytes, scene_.models.size()) {
  whole_.name = std::filesystem::path(options.target).filename().string();
  refuseWrongTargets(scene_, options.target, lacking);
}

ViewedScene::~ViewedScene() = default;

void ViewedScene::openNext() {
  const size_t number = models_.size();
  const render::MemoryShares memory = render::shareMemory(memory_.parts()[number]);
  models_.push_back(std::make_unique<InstancedModel>(number, scene_.models[number].target,
                                                     options_.streamOptions(), options_.timeout(), memory));
  models_.back()->look();
  gpu_budget_bytes_ += memory.gpu.budget_bytes;
}

/// Files one after the other, as each may have to be built; servers beside that, as they may not answer.
ViewerContent::Opening ViewedScene::open() {
  if (stage_) return {.is_open = true};
  for (const auto& model : models_) model->look();
  while (models_.size() < scene_.models.size() &&
         (models_.empty() || !models_.back()->isAwaited() || models_.back()->opener.asksServer()))
    openNext();
  const auto failed =
      std::ranges::find_if(models_, [](const auto& model) { return model->opened.error.has_value(); });
  if (failed != models_.end() && lacking_ == Lacking::kRefused) return {.error = errorOf(**failed)};
  if (const auto last = std::find_if(models_.rbegin(), models_.rend(),
                                     [](const auto& model) { return model->isAwaited(); });
      last != models_.rend())
    return {(*last)->opened.phase, (*last)->opened.part, false, std::nullopt};
  if (std::ranges::none_of(scene_.instances, [this](const SceneInstance& instance) {
        return models_[instance.model]->isOpen();
      }))
    return {.error = errorOf(*models_[scene_.instances.front().model])};
  setUp();
  return {.is_open = true};
}

/// Why it cannot be opened.
Error ViewedScene::errorOf(const InstancedModel& model) const {
  return ofSceneModel(*model.opened.error, options_.target, scene_.models[model.number]);
}

/// With the models that are open; the frame of views stays when one comes later.
void ViewedScene::setUp() {
  std::vector<const ModelSummary*> summaries;
  for (const auto& model : models_) {
    summaries.push_back(model->opened.model);
    model->instances.clear();
  }
  for (const auto& [number, placement] : scene_.instances)
    if (models_[number]->isOpen()) models_[number]->instances.push_back(placement);
  const bool is_first = !stage_, is_whole = std::ranges::all_of(models_, &InstancedModel::isOpen);
  stage_.emplace(scene_, summaries);
  const ModelSummary whole = stage_->whole();
  if (is_first) whole_.lattice = is_whole ? whole.lattice : latticeWithRoom(whole);
  whole_.triangles = whole.triangles;
  whole_.box = boxIn(whole_.lattice, whole);
}

/// Of models whose server has come meanwhile.
void ViewedScene::takeLate() {
  bool has_come = false;
  for (const auto& model : models_) {
    if (!model->look()) continue;
    giveMemory(*model);
    has_come = true;
  }
  if (!has_come) return;
  memory_.lookAnew();
  setUp();
}

std::vector<std::string> ViewedScene::missing() const {
  std::vector<std::string> missing;
  for (const auto& model : models_)
    if (const auto& error = model->opened.error)
      missing.push_back(quoted(scene_.models[model->number].name) + " is missing: " + error->what() +
                        (model->opener.triesAgain() ? "; it is tried again every few seconds" : ""));
  return missing;
}

std::vector<std::string> ViewedScene::warnings() const {
  std::vector<std::string> warnings;
  for (const auto& model : models_)
    warnings.insert(warnings.end(), model->opened.warnings.begin(), model->opened.warnings.end());
  return warnings;
}

core::View ViewedScene::inScene(const core::View& view) const {
  core::View in_scene = view;
  in_scene.eye_model += whole_.lattice.origin;
  in_scene.near_model = stage_->nearest();
  return in_scene;
}

void ViewedScene::setMemory(uint64_t budget_bytes) {
  memory_ = SceneMemory(budget_bytes, models_.size());
  gpu_budget_bytes_ = 0;
  for (const auto& model : models_) {
    const render::ResidencyOptions gpu = render::shareMemory(memory_.parts()[model->number]).gpu;
    model->renderer.setMemory(gpu);
    gpu_budget_bytes_ += gpu.budget_bytes;
    if (model->isOpen()) giveMemory(*model);
  }
}

void ViewedScene::look(const core::View& view, float threshold_px) {
  takeLate();
  const core::View scene_view = inScene(view);
  memory_.look(view, threshold_px);
  for (const auto& model : models_) {
    if (model->instances.empty()) continue;
    model->views.clear();
    for (size_t instance = 0; instance < model->instances.size(); ++instance)
      model->views.push_back(model->viewAt(instance, scene_view));
    model->opened.streamer->setViews(model->views, threshold_px);
    model->status = model->opened.streamer->status();
    if (const auto& view_cuts = model->status.view_cuts;
        view_cuts && view_cuts->cuts.size() == model->instances.size())
      model->renderer.show(view_cuts);
    else
      model->status.view_cuts = nullptr;  // it is of the first look, at the model alone
    model->dropOldProbes();
  }
  mergeStatus(view);
  shareMemory();
}

/// Gives the models other parts of the memory where one is short.
void ViewedScene::shareMemory() {
  std::vector<SceneMemory::Need> needs;
  std::vector<GpuShare> on_gpu;
  for (const auto& model : models_) {
    needs.push_back({model->status.counts.wanted_bytes, model->status.limited});
    on_gpu.push_back({render::shareMemory(memory_.parts()[model->number]).gpu.budget_bytes,
                      model->renderer.meshes().pages().capacityBytes()});
  }
  const std::vector<uint64_t> gpu_budgets = gpuBudgets(gpu_budget_bytes_, on_gpu);
  for (const auto& model : models_) model->renderer.meshes().setBudget(gpu_budgets[model->number]);
  if (!memory_.share(needs)) return;
  for (const auto& model : models_)
    if (model->isOpen()) giveMemory(*model);
}

/// Its part.
void ViewedScene::giveMemory(const InstancedModel& model) {
  const render::MemoryShares memory = render::shareMemory(memory_.parts()[model.number]);
  model.opened.streamer->setMemoryBudget(memory.stream_bytes, memory.drawn_bytes);
}

void ViewedScene::mergeStatus(const core::View& view) {
  std::vector<ModelStatus> statuses;
  for (const auto& model : models_)
    if (!model->instances.empty()) statuses.push_back({model->status, model->views.front()});
  status_ = sceneStatus(statuses, view);
}

/// One frame's budget for all models: each frame another one is the first.
void ViewedScene::uploadInRenderThread() {
  render::UploadBudget left;
  for (size_t i = 0; i < models_.size() && left.bytes > 0 && left.ms > 0; ++i) {
    InstancedModel& model = *models_[(first_upload_ + i) % models_.size()];
    if (!model.isOpen()) continue;
    left = model.renderer.uploadInRenderThread(left);
    model.opened.streamer->keep(model.renderer.meshes().takeMixtures());
  }
  ++first_upload_;
}

bool ViewedScene::upToDate() const {
  return std::ranges::all_of(models_, [](const auto& model) { return model->renderer.upToDate(); });
}

bool ViewedScene::overBudget() const {
  return std::ranges::any_of(models_,
                             [](const auto& model) { return model->renderer.meshes().overBudget(); });
}

bool ViewedScene::uploaded() const {
  return std::ranges::all_of(models_, [](const auto& model) {
    return model->renderer.upToDate() || model->renderer.meshes().overBudget();
  });
}

double ViewedScene::drawnThresholdRad() const {
  double threshold_rad = 0;
  for (const auto& model : models_)
    for (size_t instance = 0; instance < model->instances.size(); ++instance)
      if (const auto& cut = model->renderer.meshes().drawnCut(instance))
        threshold_rad = std::max(threshold_rad, thresholdRad(*cut));
  return threshold_rad;
}

uint64_t ViewedScene::drawnSerial() const {
  uint64_t serial = 0;
  for (const auto& model : models_) serial += model->renderer.meshes().drawnSerial();
  return serial;
}

bool ViewedScene::fading() const {
  return std::ranges::any_of(models_, [](const auto& model) { return model->renderer.fading(); });
}

bool ViewedScene::ageing() const {
  return std::ranges::any_of(in_picture_, [](const auto& item) { return item.age_s <= render::kOldS; });
}

ViewerContent::GpuUse ViewedScene::gpuUse() const {
  GpuUse use;
  for (const auto& model : models_) {
    use.bytes += model->renderer.gpuBytes();
    use.tiles += model->renderer.textures().tileCount();
    use.textured = use.textured || model->renderer.textures().set() != nullptr;
  }
  return use;
}

/// The places that a camera may see, the nearest first, so that little is drawn that others hide.
std::vector<ViewedScene::Standing> ViewedScene::inSight(const core::View& scene_view) const {
  std::vector<Standing> found;
  for (const auto& model : models_) {
    if (!model->isOpen()) continue;
    const core::ModelBox box = model->box();
    for (size_t instance = 0; instance < model->instances.size(); ++instance) {
      const core::View view = model->viewAt(instance, scene_view);
      if (!core::boxMayBeVisible(box, view)) continue;
      const double distance = core::distanceToBox(view.eye_model, box) * model->instances[instance].scale;
      found.push_back({distance, model.get(), instance});
    }
  }
  std::ranges::stable_sort(found, {}, &Standing::distance);
  return found;
}

/// What comes into sight again has nothing to fade from.
void ViewedScene::leaveOutAllBut(std::span<const Standing> seen) {
  for (const auto& model : models_) {
    std::vector<bool> is_seen(model->instances.size());
    for (const Standing& standing : seen)
      if (standing.model == model.get()) is_seen[standing.instance] = true;
    for (size_t instance = 0; instance < is_seen.size(); ++instance)
      if (!is_seen[instance]) model->renderer.leaveOut(instance);
  }
}

render::DrawCounts ViewedScene::draw(const core::View& view, const render::Framebuffer& target,
                                     render::DrawStyle style, const render::DrawTime& time) {
  in_picture_.clear();
  if (!stage_) return {};
  const core::View scene_view = inScene(view);
  stage_->draw(scene_view, target, style);
  const render::DrawStyle over = stage_->styleOver(style);
  const std::vector<Standing> seen = inSight(scene_view);
  leaveOutAllBut(seen);
  std::vector<render::InstanceDraw> draws;
  for (const auto& [distance, model, instance] : seen)
    draws.push_back({&model->renderer, instance, model->viewAt(instance, scene_view),
                     model->styleAt(instance, over, scene_.up)});
  const render::DrawCounts counts = instance_drawer_.draw(draws, target, time);
  for (const render::InstanceDraw& at : draws) {
    const auto items = at.renderer->inPicture(at.instance);
    in_picture_.insert(in_picture_.end(), items.begin(), items.end());
  }
  stage_->drawSky(target, style);
  return counts;
}

/// Along a ray of the scene. Nothing where it does not come down on it, or there is no ground.
std::optional<double> ViewedScene::distanceToGround(const core::Ray& ray) const {
  const double falls = -glm::dot(ray.direction, scene_.up);
  if (!scene_.ground || falls <= 0) return std::nullopt;
  const double distance = (glm::dot(ray.origin_model, scene_.up) - scene_.ground->height) / falls;
  return distance > 0 ? std::optional(distance) : std::nullopt;
}

std::optional<PickedPoint> ViewedScene::under(const core::View& view, const glm::dvec2& place_px) {
  const core::View scene_view = inScene(view);
  std::optional<PickedPoint> nearest;
  double nearest_distance = 0;
  const core::Ray scene_ray = core::rayThrough(scene_view, place_px);
  if (const auto distance = distanceToGround(scene_ray)) {
    nearest_distance = *distance;
    nearest.emplace();
    nearest->is_ground = true;
    nearest->position = scene_ray.origin_model + *distance * scene_ray.direction;
    nearest->position_model = nearest->position - whole_.lattice.origin;
    nearest->step = whole_.lattice.step;
  }
  for (const auto& [distance, model, instance] : inSight(scene_view)) {
    if (nearest && distance > nearest_distance) break;
    const core::View seen = model->viewAt(instance, scene_view);
    const core::Ray ray = core::rayThrough(seen, place_px);
    if (!core::distanceAlong(ray, model->box())) continue;
    const core::CutProbe* const probe = model->probe(instance);
    if (probe == nullptr) continue;
    const auto hit = probe->cast(ray, core::shownParts(*probe->cut(), seen));
    const double scale = model->instances[instance].scale;
    if (!hit || (nearest && hit->distance_model * scale >= nearest_distance)) continue;
    nearest_distance = hit->distance_model * scale;
    nearest = pointOf(*hit, *model->opened.model, *model->status.cut);
    nearest->position = model->toScene(instance, hit->position_model);
    nearest->position_model = nearest->position - whole_.lattice.origin;
    nearest->step *= scale;
    nearest->model = model->opened.model->name;
  }
  return nearest;
}

std::optional<render::Ground> ViewedScene::groundBelow(const core::View& view, const glm::dvec3& point_model,
                                                       const glm::dvec3& up) {
  const core::View scene_view = inScene(view);
  const glm::dvec3 point = point_model + whole_.lattice.origin;
  std::optional<render::Ground> highest;
  if (const double depth = scene_.ground ? glm::dot(point, scene_.up) - scene_.ground->height : -1;
      depth > 0 && up == scene_.up)
    highest = render::Ground{depth, 0};
  for (const auto& model : models_) {
    for (size_t instance = 0; instance < model->instances.size(); ++instance) {
      const Placement& at = model->instances[instance];
      const glm::dquat back = glm::conjugate(at.rotation);
      const glm::dvec3 from = back * (point - at.position) / at.scale - model->opened.model->lattice.origin;
      if (!core::distanceAlong({from, back * -up}, model->box())) continue;
      const core::CutProbe* const probe = model->probe(instance);
      if (probe == nullptr) continue;
      const auto ground = app::groundBelow(*probe, model->viewAt(instance, scene_view), from, back * up);
      if (ground && (!highest || ground->depth_model * at.scale < highest->depth_model))
        highest = render::Ground{ground->depth_model * at.scale, ground->uncertainty_model * at.scale};
    }
  }
  return highest;
}

}  // namespace lode::app
