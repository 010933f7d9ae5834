#include "client/app/window/scene/rendered_scene.h"

#include <algorithm>

#include "client/app/cli/child_server.h"
#include "client/app/cli/opened_target.h"
#include "client/app/cli/stream_report.h"
#include "client/app/cli/target.h"
#include "client/app/window/memory_shares.h"
#include "client/core/view/view.h"
#include "common/error.h"

namespace lode::app {

struct RenderedScene::Model {
  Model(const std::string& target_text, const CommonOptions& options, const MemoryShares& memory,
        bool announce)
      : target(resolveTarget(targetOf(options, target_text), withShare(options.streamOptions(), memory),
                             announce)),
        streamer(target.served, target.options),
        summary(openModel(streamer, target, options.timeout())),
        renderer(summary.lattice.step, memory.gpu) {}

  ResolvedTarget target;
  stream::Streamer streamer;
  ModelSummary summary;
  render::Renderer renderer;
};

RenderedScene::RenderedScene(const CommonOptions& options, bool announce)
    : scene_(sceneOf(options.target)),
      size_(options.size()),
      pixels_(options.pixels),
      timeout_(options.timeout()) {
  const std::optional<core::CameraPath> wanted = wantedPath(options);
  core::Framing framing;
  if (!wanted || scene_.is_single_model) framing = framingOf(scene_, options);
  const MemoryShares memory =
      shareMemory(options.streamOptions().engine.memory_budget_bytes / scene_.models.size());
  std::vector<const ModelSummary*> summaries;
  for (size_t model = 0; model < scene_.models.size(); ++model) {
    try {
      models_.push_back(std::make_unique<Model>(scene_.models[model].target, options, memory, announce));
    } catch (const Error& error) {
      throw ofSceneModel(error, options.target, scene_, model);
    }
    summaries.push_back(&models_.back()->summary);
  }
  if (scene_.is_single_model && (!wanted || !framing.up))
    framing = frameCoarsely(framing, models_.front()->streamer, *summaries.front(), timeout_);
  up_ = scene_.is_single_model ? core::upOf(framing) : scene_.up;
  stage_.emplace(scene_, summaries);
  path_ = wanted ? *wanted : core::framingCamera(stage_->whole(), framing);
}

RenderedScene::~RenderedScene() = default;

void RenderedScene::drawInstance(Model& model, const Placement& placement, const core::View& seen,
                                 const render::Framebuffer& target, render::DrawStyle style, double t) {
  model.renderer.uploadInRenderThread({.wait = true});
  if (!model.renderer.upToDate())
    throw Error(ErrorCode::kLimit,
                model.summary.name +
                    " needs more graphics memory than its part of the memory budget; allow "
                    "more with --memory-budget, or a larger error with --pixels");
  style.over = true;
  style.up = glm::conjugate(placement.rotation) * style.up;
  model.renderer.draw(seen, target, style, {.now_s = t});
}

RenderedScene::Picture RenderedScene::draw(double t, const render::Framebuffer& target,
                                           render::DrawStyle style) {
  style.up = up_;
  const ModelSummary at_origin;  // summary with origin 0, because the view is in true coordinates
  core::View view =
      core::toView(core::cameraAt(path_, t), path_.fov_y_deg, size_.width_px, size_.height_px, at_origin);
  view.near_model = stage_->nearest();
  stage_->begin(view, target, style);
  Picture picture;
  picture.is_drawn = picture.has_converged = true;
  std::vector<render::DrawItem> in_picture;
  std::vector<uint32_t> instances(models_.size(), 0);
  for (const auto& [number, placement] : scene_.instances) {
    Model& model = *models_[number];
    const uint32_t instance = instances[number]++;
    const core::View seen = viewFrom(view, placement, model.summary.lattice.origin);
    const core::ModelBox box = core::toModelBox(model.summary.box, model.summary.lattice.step);
    if (scene_.instances.size() > 1 && !core::boxMayBeVisible(box, seen)) continue;
    model.streamer.setView(seen, pixels_);
    const stream::StreamStatus status = model.streamer.waitForConvergence(timeout_);
    if (picture.has_converged) picture.status = status;
    picture.has_converged = picture.has_converged && hasConverged(status);
    picture.is_drawn = status.current && status.cut && status.cut->converged;
    if (!picture.is_drawn) return picture;
    picture.has_preview =
        picture.has_preview || model.target.is_preview || showsPreview(status, model.summary);
    picture.max_error_px = std::max(picture.max_error_px, status.cut->max_error_px);
    if (!scene_.is_single_model)
      style.instance = {instanceNumber(number, instance), model.summary.name, instance + 1};
    model.renderer.show(status.cut);
    drawInstance(model, placement, seen, target, style, t);
    const auto items = model.renderer.inPicture();
    in_picture.insert(in_picture.end(), items.begin(), items.end());
  }
  drawSky(models_.front()->renderer, scene_, target, style);
  picture.legend = render::legendOf(style.show, in_picture, pixels_);
  return picture;
}

}  // namespace lode::app
