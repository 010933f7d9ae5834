#include "client/app/window/scene/scene_stage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "client/app/window/memory_shares.h"
#include "client/render/passes/contact_shadows.h"
#include "client/render/passes/mesh_drawer.h"
#include "common/codec/octahedral.h"

namespace lode::app {
namespace {

constexpr uint64_t kGroundBytes = 1u << 20;  ///< memory budget for the ground's two triangles
constexpr double kGroundRadii = 40;          ///< half of the ground's side, in diagonals of the scene's box
constexpr double kShadowWidening = 1.3;      ///< size of a shadow, relative to the model's box
/// Darkness of the shadow below a model that stands on the ground. The shadow fades as the model rises, and
/// is gone once the gap between model and ground equals the model's height.
constexpr double kShadowDepth = 0.55;

constexpr double kRoom = 64;  ///< free space on each side of the scene, relative to the scene's longest side

/// Returns a corner of a model's box in scene coordinates. @param corner  bits 0, 1 and 2 select the maximum
/// of x, y and z.
glm::dvec3 cornerOf(const ModelSummary& model, const Placement& placement, unsigned corner) {
  const glm::uvec3 choice(corner & 1, corner >> 1 & 1, corner >> 2);
  const glm::uvec3 at = glm::mix(model.box.min, model.box.max, glm::bvec3(choice));
  return placement.position + placement.rotation * (placement.scale * model.lattice.toWorld(at));
}

/// Returns an elliptical shadow along the two most horizontal sides of the model's box, or nothing if the
/// model is too far above the ground or below it.
std::optional<render::ContactShadow> shadowOf(const ModelSummary& model, const Placement& placement,
                                              const glm::dvec3& up, double ground_height) {
  const glm::dvec3 first = cornerOf(model, placement, 0);
  std::array<glm::dvec3, 3> sides;
  for (unsigned axis = 0; axis < 3; ++axis)
    sides[axis] = (cornerOf(model, placement, 1u << axis) - first) / 2.0;
  const glm::dvec3 middle = first + sides[0] + sides[1] + sides[2];
  double reach = 0;  // half of the box's height along `up`
  for (const glm::dvec3& side : sides) reach += std::abs(glm::dot(side, up));
  const double above = glm::dot(middle, up) - ground_height;
  const double gap = std::max(0.0, above - reach) / std::max(2 * reach, 1e-12);
  if (gap >= 1 || above < -reach) return std::nullopt;
  std::ranges::sort(sides, {}, [&up](const glm::dvec3& side) {
    return std::abs(glm::dot(side, up)) / std::max(glm::length(side), 1e-12);
  });
  const auto levelled = [&up](const glm::dvec3& side) {
    return kShadowWidening * (side - up * glm::dot(side, up));
  };
  return render::ContactShadow{middle - up * above, levelled(sides[0]), levelled(sides[1]),
                               static_cast<float>(kShadowDepth * (1 - gap))};
}

/// Sorts shadows so that the picture does not depend on the order of instances.
void sortShadows(std::vector<render::ContactShadow>& shadows) {
  std::ranges::sort(shadows, [](const render::ContactShadow& a, const render::ContactShadow& b) {
    return std::tie(a.middle.x, a.middle.y, a.middle.z, a.depth) <
           std::tie(b.middle.x, b.middle.y, b.middle.z, b.depth);
  });
}

}  // namespace

Lattice latticeWithRoom(const ModelSummary& whole) {
  const glm::dvec3 min = whole.lattice.toWorld(whole.box.min), max = whole.lattice.toWorld(whole.box.max);
  const double longest = std::max({max.x - min.x, max.y - min.y, max.z - min.z, whole.lattice.step});
  return {min - kRoom * longest, std::exp2(std::ceil(std::log2((2 * kRoom + 1) * longest / kMaxLattice)))};
}

LatticeBox boxIn(const Lattice& lattice, const ModelSummary& whole) {
  LatticeBox box;
  box.add(lattice.snap(whole.lattice.toWorld(whole.box.min)));
  box.add(lattice.snap(whole.lattice.toWorld(whole.box.max)));
  return box;
}

struct SceneStage::Ground {
  Lattice lattice;
  std::vector<render::ContactShadow> shadows;
  render::ContactShadows shadow_pass;
  render::Renderer renderer{1, shareMemory(kGroundBytes).gpu};
};

SceneStage::~SceneStage() = default;

SceneStage::SceneStage(const Scene& scene, std::span<const ModelSummary* const> models) {
  if (scene.ground) ground_ = std::make_unique<Ground>();
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
    if (!ground_) continue;
    if (const auto shadow = shadowOf(summary, placement, scene.up, scene.ground->height))
      ground_->shadows.push_back(*shadow);
  }
  if (scene.is_single_model) {
    whole_ = *models.front();
    return;
  }
  const double longest = std::max({max.x - min.x, max.y - min.y, max.z - min.z, 1e-9});
  whole_.lattice.origin = min;
  whole_.lattice.step = std::exp2(std::ceil(std::log2(longest / kMaxLattice)));
  whole_.box.add(glm::uvec3(0));
  whole_.box.add(whole_.lattice.snap(max));
  if (ground_) makeGround(scene, min, max);
}

/// Makes the ground, a square of two triangles under the scene.
void SceneStage::makeGround(const Scene& scene, const glm::dvec3& min, const glm::dvec3& max) {
  sortShadows(ground_->shadows);
  const glm::dvec3 middle = (min + max) / 2.0, up = scene.up;
  const double reach = kGroundRadii * std::max(glm::length(max - min), 1e-9);
  Lattice& lattice = ground_->lattice;
  lattice.step = std::exp2(std::ceil(std::log2(2 * reach / kMaxLattice)));
  const glm::dvec3 across(up.y, up.z, up.x), along = glm::cross(up, across);
  const glm::dvec3 below = middle + up * (scene.ground->height - glm::dot(middle, up));
  lattice.origin = below - glm::dvec3(lattice.step * (kMaxLattice * 0.5));
  auto mesh = std::make_shared<Mesh>();
  mesh->attributes.bits = AttributeSet::kColour | AttributeSet::kNormal;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const glm::dvec3 corner =
        below + reach * (across * static_cast<double>(x) + along * static_cast<double>(y));
    mesh->positions.push_back(packPosition(lattice.snap(corner)));
    mesh->vertex_attributes.push_back(
        {encodeOctahedral(glm::vec3(up)), 0, glm::u8vec4(scene.ground->colour_srgb, 255), {}});
  }
  mesh->triangles = {{0, 1, 2}, {0, 2, 3}};
  auto cut = std::make_shared<core::Cut>();
  cut->parts.push_back({kRootKey, 0, true, 0, std::move(mesh)});
  cut->triangles = 2;
  near_ = std::max(near_, lattice.step);
  render::Renderer& renderer = ground_->renderer;
  renderer.setLatticeStep(lattice.step);
  renderer.show(std::move(cut));
  renderer.uploadInRenderThread({.wait = true});
}

void SceneStage::begin(const core::View& view, const render::Framebuffer& target,
                       const render::DrawStyle& style) {
  if (!ground_) return render::startPicture(target, style);
  render::DrawStyle surface = style;
  surface.section.reset();
  if (style.show != render::ColorMode::kUnlit) surface.show = render::ColorMode::kSurface;
  ground_->renderer.drawInstance(0, viewFrom(view, {}, ground_->lattice.origin), target, surface, {});
  if (style.show != render::ColorMode::kUnlit) ground_->shadow_pass.draw(ground_->shadows, view, target);
}

void drawSky(const render::Renderer& renderer, const Scene& scene, const render::Framebuffer& target,
             render::DrawStyle style) {
  if (scene.sky && !style.hides_sky) {
    style.background_top_srgb = glm::vec3(scene.sky->top_srgb) / 255.0f;
    style.background_bottom_srgb = glm::vec3(scene.sky->bottom_srgb) / 255.0f;
  }
  renderer.drawBackground(target, style);
}

}  // namespace lode::app
