#include "client/app/window/scene/scene_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "common/codec/octahedral.h"

namespace lode::app {
namespace {

constexpr double kGroundRadii = 40;      ///< of the scene, that the ground reaches
constexpr double kShadowWidening = 1.3;  ///< of a model's box
constexpr double kShadowDepth = 0.55;    ///< of what stands on the ground; none at its own height above it

/// Where a corner of a model's box is in the scene.
glm::dvec3 cornerOf(const ModelSummary& model, const Placement& placement, unsigned corner) {
  const glm::uvec3 choice(corner & 1, corner >> 1 & 1, corner >> 2);
  const glm::uvec3 at = glm::mix(model.box.min, model.box.max, glm::bvec3(choice));
  return placement.position + placement.rotation * (placement.scale * model.lattice.toWorld(at));
}

}  // namespace

SceneStage::SceneStage(const Scene& scene, std::span<const ModelSummary* const> models)
    : up_(scene.up), sky_(scene.sky) {
  glm::dvec3 min(std::numeric_limits<double>::infinity()), max = -min;
  for (const auto& [model, placement] : scene.instances) {
    if (models[model] == nullptr) continue;
    const ModelSummary& summary = *models[model];
    whole_.triangles += summary.triangles;
    near_ = std::max(near_, summary.lattice.step * placement.scale);
    for (unsigned corner = 0; corner < 8; ++corner) {
      const glm::dvec3 point = cornerOf(summary, placement, corner);
      min = glm::min(min, point);
      max = glm::max(max, point);
    }
    if (scene.ground) addShadow(summary, placement, scene.ground->height);
  }
  const double longest = std::max({max.x - min.x, max.y - min.y, max.z - min.z, 1e-9});
  whole_.lattice.origin = min;
  whole_.lattice.step = std::exp2(std::ceil(std::log2(longest / kMaxLattice)));
  whole_.box.add(glm::uvec3(0));
  whole_.box.add(whole_.lattice.snap(max));
  if (scene.ground) makeGround(scene, min, max);
  // So that the picture does not depend on the order of instances.
  std::ranges::sort(shadows_, [](const render::ContactShadow& a, const render::ContactShadow& b) {
    return std::tie(a.middle.x, a.middle.y, a.middle.z, a.depth) <
           std::tie(b.middle.x, b.middle.y, b.middle.z, b.depth);
  });
}

/// An ellipse below a model's box, as that stands: its level sides, whichever are the most level.
void SceneStage::addShadow(const ModelSummary& model, const Placement& placement, double ground_height) {
  const glm::dvec3 first = cornerOf(model, placement, 0);
  std::array<glm::dvec3, 3> sides;
  for (unsigned axis = 0; axis < 3; ++axis)
    sides[axis] = (cornerOf(model, placement, 1u << axis) - first) / 2.0;
  const glm::dvec3 middle = first + sides[0] + sides[1] + sides[2];
  double reach = 0;  // of the box, along up
  for (const glm::dvec3& side : sides) reach += std::abs(glm::dot(side, up_));
  const double above = glm::dot(middle, up_) - ground_height;
  const double gap = std::max(0.0, above - reach) / std::max(2 * reach, 1e-12);
  if (gap >= 1 || above < -reach) return;
  std::ranges::sort(sides, {}, [this](const glm::dvec3& side) {
    return std::abs(glm::dot(side, up_)) / std::max(glm::length(side), 1e-12);
  });
  const auto levelled = [this](const glm::dvec3& side) {
    return kShadowWidening * (side - up_ * glm::dot(side, up_));
  };
  shadows_.push_back({middle - up_ * above, levelled(sides[0]), levelled(sides[1]),
                      static_cast<float>(kShadowDepth * (1 - gap))});
}

/// A square around the scene, as a model of two triangles.
void SceneStage::makeGround(const Scene& scene, const glm::dvec3& min, const glm::dvec3& max) {
  const glm::dvec3 middle = (min + max) / 2.0;
  const double reach = kGroundRadii * std::max(glm::length(max - min), 1e-9);
  ground_lattice_.step = std::exp2(std::ceil(std::log2(2 * reach / kMaxLattice)));
  const glm::dvec3 across(up_.y, up_.z, up_.x), along = glm::cross(up_, across);
  const glm::dvec3 below = middle + up_ * (scene.ground->height - glm::dot(middle, up_));
  ground_lattice_.origin = below - glm::dvec3(ground_lattice_.step * (kMaxLattice * 0.5));
  auto mesh = std::make_shared<Mesh>();
  mesh->attributes.bits = AttributeSet::kColour | AttributeSet::kNormal;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const glm::dvec3 corner =
        below + reach * (across * static_cast<double>(x) + along * static_cast<double>(y));
    mesh->positions.push_back(packPosition(ground_lattice_.snap(corner)));
    mesh->vertex_attributes.push_back(
        {encodeOctahedral(glm::vec3(up_)), 0, glm::u8vec4(scene.ground->colour_srgb, 255), {}});
  }
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  auto cut = std::make_shared<core::Cut>();
  cut->parts.push_back({kRootKey, 0, true, 0, std::move(mesh)});
  cut->triangles = 2;
  backdrop_.setLatticeStep(ground_lattice_.step);
  near_ = std::max(near_, ground_lattice_.step);
  backdrop_.show(std::move(cut));
  backdrop_.uploadInRenderThread({.wait = true});
}

render::DrawStyle SceneStage::styleOf(render::DrawStyle style) const {
  style.up = up_;
  if (!sky_) return style;
  style.background_top_srgb = glm::vec3(sky_->top_srgb) / 255.0f;
  style.background_bottom_srgb = glm::vec3(sky_->bottom_srgb) / 255.0f;
  return style;
}

render::DrawStyle SceneStage::styleOver(const render::DrawStyle& style) const {
  render::DrawStyle over = styleOf(style);
  over.over = true;
  return over;
}

void SceneStage::draw(const core::View& view, const render::Framebuffer& target,
                      const render::DrawStyle& style) {
  render::DrawStyle surface = styleOf(style);
  if (style.show != render::ColorMode::kUnlit) surface.show = render::ColorMode::kSurface;
  backdrop_.drawInstance(0, viewFrom(view, {}, ground_lattice_.origin), target, surface, {});
  if (style.show != render::ColorMode::kUnlit) shadow_pass_.draw(shadows_, view, target);
}

void SceneStage::drawSky(const render::Framebuffer& target, const render::DrawStyle& style) const {
  backdrop_.drawBackground(target, styleOf(style));
}

}  // namespace lode::app
