#include "client/app/window/scene/viewed_scene.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "client/app/cli/opened_target.h"
#include "client/app/cli/remedy_words.h"
#include "client/app/window/memory_shares.h"
#include "client/app/window/scene/scene_status.h"
#include "client/core/lod/cut.h"
#include "client/render/passes/mesh_drawer.h"

namespace lode::app {
namespace {

/// Rejects a scene with invalid targets before any model is opened. If missing models are allowed, only a
/// usage error or a scene without any valid instance is rejected. @throws Error.
void refuseWrongTargets(const Scene& scene, const std::string& source, MissingModels missing_models) {
  std::vector<std::optional<Error>> refused(scene.models.size());
  for (size_t model = 0; model < scene.models.size(); ++model) {
    try {
      parseTarget(scene.models[model].target);
    } catch (const Error& error) {
      refused[model] = ofSceneModel(error, source, scene, model);
      if (missing_models == MissingModels::kRefused || error.code() == ErrorCode::kUsage)
        throw *refused[model];
    }
  }
  if (std::ranges::all_of(scene.instances, [&refused](const SceneInstance& instance) {
        return refused[instance.model].has_value();
      }))
    throw *refused[scene.instances.front().model];
}

/// Returns the scene that a target names, or a scene without models if there is no target.
Scene sceneOrNone(const std::string& target) {
  if (!target.empty()) return sceneOf(target);
  Scene scene;
  scene.is_single_model = true;
  return scene;
}

stream::StreamOptions streamOptionsOf(const CommonOptions& common, const Scene& scene) {
  stream::StreamOptions options = common.streamOptions();
  options.engine.refine.hysteresis_factor = core::kHysteresisFactor;
  options.engine.refine.shares_memory = scene.models.size() > 1;
  options.engine.prefetch = scene.instances.size() == 1;
  options.engine.session.awaits_model = true;
  return options;
}

/// Transforms a section plane of the scene into an instance's model frame.
render::Section sectionOf(const render::Section& in_scene, const InstancedModel& model, size_t instance) {
  const glm::dvec3 on_plane = model.toModel(instance, in_scene.normal * in_scene.offset_model);
  render::Section section = in_scene;
  section.normal = glm::conjugate(model.instances[instance].rotation) * in_scene.normal;
  section.offset_model = glm::dot(section.normal, on_plane);
  return section;
}

}  // namespace

ViewedScene::ViewedScene(const CommonOptions& options, MissingModels missing_models)
    : scene_(sceneOrNone(options.target)),
      options_(options),
      missing_models_(missing_models),
      framing_(framingOf(scene_, options)),
      memory_(options.streamOptions().engine.memory_budget_bytes, scene_.models.size()) {
  if (scene_.models.empty()) return;
  whole_.name = std::filesystem::path(options.target).filename().string();
  refuseWrongTargets(scene_, options.target, missing_models);
  first_opener_ = openerOf(0);
}

ViewedScene::~ViewedScene() = default;

/// Begins to open a model's target. Needs no OpenGL. Shows a preview only if the scene has one model, because
/// several models are built one after another.
std::unique_ptr<RetryingOpener> ViewedScene::openerOf(size_t number) const {
  const bool shows_previews = missing_models_ == MissingModels::kAllowed && scene_.models.size() == 1;
  return std::make_unique<RetryingOpener>(
      scene_.models[number].target, options_.textures_folder,
      withShare(streamOptionsOf(options_, scene_), app::shareMemory(memory_.parts()[number])), framing_,
      options_.timeout(), shows_previews);
}

void ViewedScene::openNext() {
  const size_t number = models_.size();
  const MemoryShares memory = app::shareMemory(memory_.parts()[number]);
  std::unique_ptr<RetryingOpener> opener = number == 0 ? std::move(first_opener_) : openerOf(number);
  models_.push_back(std::make_unique<InstancedModel>(number, std::move(opener), memory));
  models_.back()->poll();
  gpu_budget_bytes_ += memory.gpu.budget_bytes;
}

/// Opens the models: local files one after another, because each may need a build, and models on servers in
/// parallel, because a server may not answer.
ViewedScene::Opening ViewedScene::open() {
  if (stage_) return {.is_open = true};
  if (scene_.models.empty()) return {};
  for (const auto& model : models_) model->poll();
  while (models_.size() < scene_.models.size() &&
         (models_.empty() || !models_.back()->isAwaited() || models_.back()->opener->targetIsServer()))
    openNext();
  const auto failed =
      std::ranges::find_if(models_, [](const auto& model) { return model->opened.error.has_value(); });
  if (failed != models_.end() && missing_models_ == MissingModels::kRefused)
    return {.error = errorOf(**failed)};
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

Error ViewedScene::errorOf(const InstancedModel& model) const {
  return ofSceneModel(*model.opened.error, options_.target, scene_, model.number);
}

core::Framing ViewedScene::framing() const {
  return scene_.is_single_model ? models_.front()->opened.framing : framing_;
}

/// Sets up the stage and the instances of all open models that are not hidden. The first call chooses the
/// coordinate frame of views; later calls, for models that open later, keep this frame.
void ViewedScene::setUp() {
  std::vector<const ModelSummary*> summaries;
  for (const auto& model : models_) summaries.push_back(model->is_hidden ? nullptr : model->opened.model);
  const bool is_first = !stage_, is_whole = std::ranges::all_of(models_, &InstancedModel::isOpen);
  stage_.emplace(scene_, summaries);
  const ModelSummary whole = stage_->whole();
  if (scene_.is_single_model) {
    whole_ = whole;
  } else {
    if (is_first) whole_.lattice = is_whole ? whole.lattice : latticeWithRoom(whole);
    whole_.triangles = whole.triangles;
    whole_.box = boxIn(whole_.lattice, whole);
  }
  for (const auto& model : models_) model->instances.clear();
  for (auto [number, placement] : scene_.instances) {
    if (!models_[number]->isOpen() || models_[number]->is_hidden) continue;
    placement.position -= whole_.lattice.origin;
    models_[number]->instances.push_back(placement);
  }
}

/// Adds models that have opened since the last frame.
void ViewedScene::addLateModels() {
  bool has_opened = false;
  for (const auto& model : models_) {
    if (!model->poll()) continue;
    applyShare(*model);
    has_opened = true;
  }
  if (!has_opened) return;
  memory_.allowChanges();
  setUp();
}

std::optional<ViewedScene::Preview> ViewedScene::preview() const {
  for (const auto& model : models_)
    if (model->isOpen() && model->opened.is_preview) return Preview{model->opened.phase, model->opened.part};
  return std::nullopt;
}

std::vector<std::string> ViewedScene::missing() const {
  std::vector<std::string> missing;
  for (const auto& model : models_)
    if (const auto& error = model->opened.error)
      missing.push_back(quoted(scene_.models[model->number].name) + " is missing: " + messageOf(*error) +
                        (model->opener->retries() ? "; it is tried again every few seconds" : ""));
  return missing;
}

std::vector<std::string> ViewedScene::warnings() const {
  std::vector<std::string> warnings;
  for (const auto& model : models_)
    warnings.insert(warnings.end(), model->opened.warnings.begin(), model->opened.warnings.end());
  return warnings;
}

core::View ViewedScene::withNear(const core::View& view) const {
  core::View near = view;
  near.near_model = stage_->nearest();
  return near;
}

core::View ViewedScene::inTrueCoordinates(const core::View& view) const {
  core::View moved = withNear(view);
  moved.eye_model += whole_.lattice.origin;
  return moved;
}

void ViewedScene::setMemory(uint64_t budget_bytes) {
  memory_ = SceneMemory(budget_bytes, models_.size());
  gpu_budget_bytes_ = 0;
  for (const auto& model : models_) {
    const render::ResidencyOptions gpu = app::shareMemory(memory_.parts()[model->number]).gpu;
    model->renderer.setMemory(gpu);
    gpu_budget_bytes_ += gpu.budget_bytes;
    if (model->isOpen()) applyShare(*model);
  }
}

void ViewedScene::update(const core::View& view, float threshold_px) {
  addLateModels();
  const core::View scene_view = withNear(view);
  memory_.setView(view, threshold_px);
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
      model->status.view_cuts = nullptr;  // the current cut is still for the view that ModelOpener set
    model->dropOldProbes();
  }
  mergeStatus(view);
  shareMemory();
}

/// Sets the GPU budgets, and divides the memory anew if a model is short of memory.
void ViewedScene::shareMemory() {
  std::vector<SceneMemory::Need> needs;
  std::vector<GpuShare> on_gpu;
  for (const auto& model : models_) {
    needs.push_back({model->status.counts.wanted_bytes, model->status.limited});
    on_gpu.push_back({app::shareMemory(memory_.parts()[model->number]).gpu.budget_bytes,
                      model->renderer.meshes().pages().capacityBytes()});
  }
  const std::vector<uint64_t> gpu_budgets = gpuBudgets(gpu_budget_bytes_, on_gpu);
  for (const auto& model : models_) model->renderer.meshes().setBudget(gpu_budgets[model->number]);
  if (!memory_.share(needs)) return;
  for (const auto& model : models_)
    if (model->isOpen()) applyShare(*model);
}

/// Sets the budgets of a model's stream to the model's part of the memory.
void ViewedScene::applyShare(const InstancedModel& model) {
  const MemoryShares memory = app::shareMemory(memory_.parts()[model.number]);
  model.opened.streamer->setMemoryBudget(memory.stream_bytes, memory.drawn_bytes);
}

void ViewedScene::mergeStatus(const core::View& view) {
  std::vector<ModelStatus> statuses;
  for (const auto& model : models_)
    if (!model->instances.empty()) statuses.push_back({model->status, model->views.front()});
  status_ = sceneStatus(statuses, view);
}

/// Spends the upload budget of one frame on all models. A different model goes first in each frame.
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

ViewedScene::GpuUse ViewedScene::gpuUse() const {
  GpuUse use;
  for (const auto& model : models_) {
    use.bytes += model->renderer.gpuBytes();
    use.tiles += model->renderer.textures().tileCount();
    use.textured = use.textured || model->renderer.textures().set() != nullptr;
  }
  return use;
}

/// Returns the instances whose boxes may be in the picture, sorted by distance. Near instances come first,
/// because they may hide others.
std::vector<ViewedScene::VisibleInstance> ViewedScene::visibleInstances(const core::View& view) const {
  std::vector<VisibleInstance> found;
  for (const auto& model : models_) {
    if (!model->isOpen()) continue;
    const core::ModelBox box = model->box();
    for (size_t instance = 0; instance < model->instances.size(); ++instance) {
      const core::View seen = model->viewAt(instance, view);
      if (!core::boxMayBeVisible(box, seen)) continue;
      const double distance = core::distanceToBox(seen.eye_model, box) * model->instances[instance].scale;
      found.push_back({distance, model.get(), instance});
    }
  }
  std::ranges::stable_sort(found, {}, &VisibleInstance::distance);
  return found;
}

/// Ends the fades of all instances that are out of the picture, so that these instances do not fade when they
/// appear again.
void ViewedScene::forgetInvisible(std::span<const VisibleInstance> visible) {
  for (const auto& model : models_) {
    std::vector<bool> is_visible(model->instances.size());
    for (const VisibleInstance& one : visible)
      if (one.model == model.get()) is_visible[one.instance] = true;
    for (size_t instance = 0; instance < is_visible.size(); ++instance)
      if (!is_visible[instance]) model->renderer.leaveOut(instance);
  }
}

render::DrawStyle ViewedScene::styleOf(const VisibleInstance& visible, render::DrawStyle style) const {
  const auto& [distance, model, instance] = visible;
  style.over = true;
  const Placement& at = model->instances[instance];
  style.up = glm::conjugate(at.rotation) * style.up;
  if (style.section) style.section = sectionOf(*style.section, *model, instance);
  if (!scene_.is_single_model)
    style.instance = {instanceNumber(model->number, instance), model->opened.model->name,
                      static_cast<uint32_t>(instance + 1)};
  return style;
}

render::DrawCounts ViewedScene::draw(const core::View& view, const render::Framebuffer& target,
                                     render::DrawStyle style, const render::DrawTime& time) {
  in_picture_.clear();
  render::DrawCounts counts;
  if (stage_) {
    stage_->begin(inTrueCoordinates(view), target, style);
    const core::View scene_view = withNear(view);
    const std::vector<VisibleInstance> visible = visibleInstances(scene_view);
    forgetInvisible(visible);
    std::vector<render::InstanceDraw> draws;
    for (const VisibleInstance& one : visible)
      draws.push_back({&one.model->renderer, one.instance, one.model->viewAt(one.instance, scene_view),
                       styleOf(one, style)});
    counts = instance_drawer_.draw(draws, target, time);
    for (const render::InstanceDraw& at : draws) {
      const auto items = at.renderer->inPicture(at.instance);
      in_picture_.insert(in_picture_.end(), items.begin(), items.end());
    }
  } else {
    render::startPicture(target, style);
  }
  if (models_.empty()) {
    if (!background_renderer_) background_renderer_.emplace();
    background_renderer_->drawBackground(target, style);
  } else {
    drawSky(models_.front()->renderer, scene_, target, style);
  }
  return counts;
}

}  // namespace lode::app
