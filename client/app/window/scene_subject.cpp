#include "client/app/window/scene_subject.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "client/app/cli/child_server.h"
#include "client/app/cli/first_camera.h"
#include "client/app/cli/opened_target.h"
#include "client/app/cli/target.h"
#include "client/core/sight.h"
#include "client/render/memory_shares.h"
#include "common/error.h"
#include "common/octahedral.h"

namespace lode::app {
namespace {

constexpr double kGroundRadii = 40;  ///< of the scene, that the ground reaches

CommonOptions optionsOf(const CommonOptions& scene, const std::string& target) {
  CommonOptions options = scene;
  options.target = target;
  return options;
}

render::MemoryShares shareOf(const CommonOptions& options, size_t models) {
  return render::shareMemory(options.streamOptions().memory_budget_bytes / models);
}

stream::StreamOptions streamOptionsOf(const CommonOptions& options, const render::MemoryShares& memory) {
  stream::StreamOptions stream_options = options.streamOptions();
  stream_options.memory_budget_bytes = memory.stream_bytes;
  stream_options.drawn_budget_bytes = memory.drawn_bytes;
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
  for (const std::string& target : scene_.models) {
    const CommonOptions of_model = optionsOf(options, target);
    models_.push_back(std::make_unique<Model>(of_model, shareOf(of_model, scene_.models.size()), announce));
  }
  min_ = glm::dvec3(std::numeric_limits<double>::infinity());
  max_ = -min_;
  for (const auto& [model, placement] : scene_.instances) {
    const ModelSummary& summary = models_[model]->summary;
    near_ = std::max(near_, summary.lattice.step * placement.scale);
    for (unsigned corner = 0; corner < 8; ++corner) {
      const glm::uvec3 choice(corner & 1, corner >> 1 & 1, corner >> 2);
      const glm::uvec3 at = glm::mix(summary.box.min, summary.box.max, glm::bvec3(choice));
      const glm::dvec3 point =
          placement.position + placement.rotation * (placement.scale * summary.lattice.toWorld(at));
      min_ = glm::min(min_, point);
      max_ = glm::max(max_, point);
    }
  }
  path_ = framingPath(options);
  if (scene_.ground) makeGround();
}

SceneSubject::~SceneSubject() = default;

/// The one asked for, or the camera that frames a model of the scene's size.
core::CameraPath SceneSubject::framingPath(const CommonOptions& options) const {
  if (const auto wanted = wantedPath(options)) return *wanted;
  core::Framing framing = wantedFraming(options);
  if (!framing.up) framing.up = scene_.up;
  ModelSummary whole;
  const double longest = std::max({max_.x - min_.x, max_.y - min_.y, max_.z - min_.z, 1e-9});
  whole.lattice.origin = min_;
  whole.lattice.step = std::exp2(std::ceil(std::log2(longest / kMaxLattice)));
  whole.box.add(glm::uvec3(0));
  whole.box.add(whole.lattice.snap(max_));
  return core::framingCamera(whole, framing);
}

/// A square around the scene, as a model of two triangles.
void SceneSubject::makeGround() {
  const glm::dvec3 up = scene_.up, middle = (min_ + max_) / 2.0;
  const double reach = kGroundRadii * std::max(glm::length(max_ - min_), 1e-9);
  ground_lattice_.step = std::exp2(std::ceil(std::log2(2 * reach / kMaxLattice)));
  ground_lattice_.origin = middle - glm::dvec3(ground_lattice_.step * (kMaxLattice * 0.5));
  const glm::dvec3 across(up.y, up.z, up.x), along = glm::cross(up, across);
  const glm::dvec3 below = middle + up * (scene_.ground->height - glm::dot(middle, up));
  auto mesh = std::make_shared<Mesh>();
  mesh->attributes.bits = AttributeSet::kColour | AttributeSet::kNormal;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const glm::dvec3 corner =
        below + reach * (across * static_cast<double>(x) + along * static_cast<double>(y));
    mesh->positions.push_back(packPosition(ground_lattice_.snap(corner)));
    mesh->vertex_attributes.push_back(
        {encodeOctahedral(glm::vec3(up)), 0, glm::u8vec4(scene_.ground->colour_srgb, 255), {}});
  }
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  auto cut = std::make_shared<core::Cut>();
  cut->parts.push_back({kRootKey, 0, true, 0, std::move(mesh)});
  cut->triangles = 2;
  ground_ = std::move(cut);
  backdrop_.setLatticeStep(ground_lattice_.step);
  near_ = std::max(near_, ground_lattice_.step);
  backdrop_.show(ground_);
  backdrop_.uploadInRenderThread({.wait = true});
}

/// Behind all: the sky, and the ground if there is one.
void SceneSubject::drawGround(const core::View& view, const render::Framebuffer& target,
                              const render::DrawStyle& style) {
  render::DrawStyle surface = style;
  if (style.show != render::Show::kUnlit) surface.show = render::Show::kSurface;
  backdrop_.draw(viewFrom(view, {}, ground_lattice_.origin), target, surface);
}

Taken SceneSubject::take(double t, const render::Framebuffer& target, render::DrawStyle style) {
  const ModelSummary in_scene;  // whose origin is the scene's
  core::View view =
      core::toView(core::cameraAt(path_, t), path_.fov_y_deg, size_.width_px, size_.height_px, in_scene);
  view.near_model = near_;
  style.up = scene_.up;
  if (scene_.sky) {
    style.background_top_srgb = glm::vec3(scene_.sky->top_srgb) / 255.0f;
    style.background_bottom_srgb = glm::vec3(scene_.sky->bottom_srgb) / 255.0f;
  }
  drawGround(view, target, style);
  style.over = true;
  Taken taken;
  taken.is_finest = true;
  for (const auto& [number, placement] : scene_.instances) {
    Model& model = *models_[number];
    const core::View seen = viewFrom(view, placement, model.summary.lattice.origin);
    if (!core::boxMayBeVisible(core::toModelBox(model.summary.box, model.summary.lattice.step), seen))
      continue;
    model.streamer.setView(seen, pixels_);
    const stream::StreamStatus status = model.streamer.waitForConvergence(timeout_);
    const bool is_finest = status.cut && status.cut->converged;
    if (taken.is_finest && taken.max_error_px <= pixels_) taken.status = status;
    taken.is_finest = taken.is_finest && is_finest;
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
    if (style.show != render::Show::kSurface)
      taken.legend = render::legendOf(style.show, model.renderer.inPicture(), pixels_);
  }
  return taken;
}

}  // namespace lode::app
