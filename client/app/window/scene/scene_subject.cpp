#include "client/app/window/scene/scene_subject.h"

#include <algorithm>

#include "client/app/cli/child_server.h"
#include "client/app/cli/first_camera.h"
#include "client/app/cli/not_converged.h"
#include "client/app/cli/opened_target.h"
#include "client/app/cli/target.h"
#include "client/app/window/memory_shares.h"
#include "client/core/view/view.h"
#include "common/error.h"

namespace lode::app {
namespace {

CommonOptions optionsOf(const CommonOptions& scene, const std::string& target) {
  CommonOptions options = scene;
  options.target = target;
  return options;
}

render::MemoryShares shareOf(const CommonOptions& options, size_t models) {
  return render::shareMemory(options.streamOptions().engine.memory_budget_bytes / models);
}

stream::StreamOptions streamOptionsOf(const CommonOptions& options, const render::MemoryShares& memory) {
  stream::StreamOptions stream_options = options.streamOptions();
  stream_options.engine.memory_budget_bytes = memory.stream_bytes;
  stream_options.engine.refine.drawn_budget_bytes = memory.drawn_bytes;
  return stream_options;
}

}  // namespace

struct SceneSubject::Model {
  Model(const CommonOptions& options, const render::MemoryShares& memory, bool announce)
      : target(resolveTarget(parseTarget(options.target), streamOptionsOf(options, memory), announce)),
        streamer(target.served, target.options),
        summary(openModel(streamer, target, options.timeout())),
        renderer(summary.lattice.step, memory.gpu) {}

  ResolvedTarget target;
  stream::Streamer streamer;
  ModelSummary summary;
  render::Renderer renderer;
};

SceneSubject::SceneSubject(const CommonOptions& options, bool announce)
    : scene_(readScene(options.target)),
      size_(options.size()),
      pixels_(options.pixels),
      timeout_(options.timeout()) {
  for (const SceneModel& model : scene_.models) {
    try {
      const CommonOptions of_model = optionsOf(options, model.target);
      models_.push_back(std::make_unique<Model>(of_model, shareOf(of_model, scene_.models.size()), announce));
    } catch (const Error& error) {
      throw ofSceneModel(error, options.target, model);
    }
  }
  std::vector<const ModelSummary*> summaries;
  for (const auto& model : models_) summaries.push_back(&model->summary);
  stage_.emplace(scene_, summaries);
  path_ = framingPath(options);
}

SceneSubject::~SceneSubject() = default;

/// The one asked for, or the camera that frames a model of the scene's size.
core::CameraPath SceneSubject::framingPath(const CommonOptions& options) const {
  if (const auto wanted = wantedPath(options)) return *wanted;
  return core::framingCamera(stage_->whole(), framingOf(scene_, options));
}

Taken SceneSubject::take(double t, const render::Framebuffer& target, render::DrawStyle style) {
  const ModelSummary in_scene;  // whose origin is the scene's
  core::View view =
      core::toView(core::cameraAt(path_, t), path_.fov_y_deg, size_.width_px, size_.height_px, in_scene);
  view.near_model = stage_->nearest();
  const render::DrawStyle asked = style;
  stage_->draw(view, target, asked);
  style = stage_->styleOver(asked);
  Taken taken;
  taken.is_finest = taken.has_converged = true;
  std::vector<render::DrawItem> in_picture;
  std::vector<uint32_t> instances(models_.size(), 0);
  for (const auto& [number, placement] : scene_.instances) {
    Model& model = *models_[number];
    const uint32_t instance = instances[number]++;
    style.instance = {instanceNumber(number, instance), model.summary.name, instance + 1};
    const core::View seen = viewFrom(view, placement, model.summary.lattice.origin);
    if (!core::boxMayBeVisible(core::toModelBox(model.summary.box, model.summary.lattice.step), seen))
      continue;
    model.streamer.setView(seen, pixels_);
    const stream::StreamStatus status = model.streamer.waitForConvergence(timeout_);
    const bool is_finest = status.cut && status.cut->converged;
    if (taken.has_converged) taken.status = status;
    taken.has_converged = taken.has_converged && hasConverged(status, pixels_);
    taken.is_finest = is_finest;
    if (!is_finest) return taken;
    taken.max_error_px = std::max(taken.max_error_px, status.cut->max_error_px);
    model.renderer.show(status.cut);
    model.renderer.uploadInRenderThread({.wait = true});
    if (!model.renderer.upToDate())
      throw Error(ErrorCode::kLimit,
                  model.summary.name +
                      " needs more graphics memory than its part of the scene's; allow more "
                      "with --memory-budget, or a larger error with --pixels");
    style.up = glm::conjugate(placement.rotation) * scene_.up;
    model.renderer.draw(seen, target, style, {.now_s = t});
    const auto items = model.renderer.inPicture();
    in_picture.insert(in_picture.end(), items.begin(), items.end());
  }
  stage_->drawSky(target, asked);
  taken.legend = render::legendOf(style.show, in_picture, pixels_);
  return taken;
}

}  // namespace lode::app
