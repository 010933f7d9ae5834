#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "client/app/window/scene/snapping.h"
#include "client/app/window/scene/viewed_scene.h"
#include "client/app/window/section_plane.h"
#include "client/core/lod/cut.h"

/// Part of ViewedScene that finds points of the drawn surfaces.
namespace lode::app {

/// Returns the point where a ray meets the scene's ground from above.
/// @param ray       ray in the scene.
/// @param distance  receives the distance from the eye to the point, if there is one.
std::optional<PickedPoint> ViewedScene::groundUnder(const core::Ray& ray, double& distance) const {
  const double fall = -glm::dot(ray.direction, scene_.up);
  if (!scene_.ground || fall <= 0) return std::nullopt;
  const glm::dvec3 eye = ray.origin_model + whole_.lattice.origin;
  const double to_ground = (glm::dot(eye, scene_.up) - scene_.ground->height) / fall;
  if (!(to_ground > 0)) return std::nullopt;
  distance = to_ground;
  PickedPoint point;
  point.is_ground = true;
  point.position_model = ray.origin_model + to_ground * ray.direction;
  point.position = point.position_model + whole_.lattice.origin;
  point.step = whole_.lattice.step;
  return point;
}

/// A section never cuts the ground. If the nearest surface behind the section shows its back, the pointer is
/// on the cut of a solid, and the picked point is in the section's plane.
std::optional<PickedPoint> ViewedScene::under(const core::View& view, const glm::dvec2& pixel_px,
                                              const std::optional<render::Section>& section) {
  const core::View scene_view = withNear(view);
  const core::Ray scene_ray = core::rayThrough(scene_view, pixel_px);
  double nearest_distance = 0;
  std::optional<PickedPoint> nearest = groundUnder(scene_ray, nearest_distance);
  ShownRay shown_ray{scene_ray.origin_model, std::numeric_limits<double>::infinity()};
  if (section) {
    const auto cut = shownRay(scene_ray.origin_model, scene_ray.direction, *section);
    if (!cut) return nearest;
    shown_ray = *cut;
  }
  const double cut_off = glm::distance(shown_ray.origin_model, scene_ray.origin_model);
  for (const auto& [distance, model, instance] : visibleInstances(scene_view)) {
    if (nearest && distance > nearest_distance) break;
    const core::View seen = model->viewAt(instance, scene_view);
    core::Ray ray = core::rayThrough(seen, pixel_px);
    if (section) ray.origin_model = model->toModel(instance, shown_ray.origin_model);
    if (!core::distanceAlong(ray, model->box())) continue;
    const core::CutProbe* const probe = model->probe(instance);
    if (probe == nullptr) continue;
    const auto hit = probe->cast(ray, core::shownParts(*probe->cut(), seen));
    const double scale = model->instances[instance].scale;
    if (!hit || hit->distance_model * scale > shown_ray.most_model) continue;
    if (nearest && hit->distance_model * scale + cut_off >= nearest_distance) continue;
    nearest_distance = hit->distance_model * scale + cut_off;
    nearest = pointInScene(*model, instance, *hit);
    nearest->seen_along = {shown_ray.origin_model, scene_ray.direction};
  }
  const bool is_on_cut = nearest && !nearest->is_ground && shown_ray.begins_in_cut &&
                         glm::dot(nearest->normal, scene_ray.direction) > 0;
  return is_on_cut ? onCut(*nearest, shown_ray.origin_model) : nearest;
}

/// Returns the point where a ray enters a solid at the section. @param behind  point where the ray has hit
/// the solid's back.
PickedPoint ViewedScene::onCut(const PickedPoint& behind, const glm::dvec3& point_model) const {
  PickedPoint point;
  point.position_model = point_model;
  point.position = point_model + whole_.lattice.origin;
  point.is_on_cut = true;
  point.step = behind.step;
  point.model = behind.model;
  point.model_number = behind.model_number;
  point.instance = behind.instance;
  return point;
}

/// Returns the picked point of a hit on an instance, in the scene.
PickedPoint ViewedScene::pointInScene(const InstancedModel& model, size_t instance,
                                      const core::Hit& hit) const {
  const Placement& at = model.instances[instance];
  PickedPoint point = pointOf(hit, *model.opened.model, *model.status.cut);
  point.position_model = model.toScene(instance, hit.position_model);
  point.position = point.position_model + whole_.lattice.origin;
  point.step *= at.scale;
  point.error *= at.scale;
  point.normal = at.rotation * point.normal;
  point.model_number = model.number;
  point.instance = instance;
  if (!scene_.is_single_model) point.model = model.opened.model->name;
  return point;
}

std::optional<PickedPoint> ViewedScene::snapped(const core::View& view, const PickedPoint& point) {
  const auto found =
      std::ranges::find(models_, point.model_number, [](const auto& model) { return model->number; });
  if (point.is_ground || point.is_on_cut || found == models_.end() ||
      point.instance >= (*found)->instances.size())
    return std::nullopt;
  InstancedModel& model = **found;
  const core::CutProbe* const probe = model.probe(point.instance);
  if (probe == nullptr) return std::nullopt;
  const std::vector<uint32_t> shown =
      core::shownParts(*probe->cut(), model.viewAt(point.instance, withNear(view)));
  const Placement& at = model.instances[point.instance];
  for (const core::Ray& ray : snappingRays(point)) {
    const core::Ray in_model{model.toModel(point.instance, ray.origin_model),
                             glm::conjugate(at.rotation) * ray.direction};
    const auto hit = probe->cast(in_model, shown);
    if (!hit || hit->part->error_model * at.scale >= point.error) continue;
    PickedPoint finer = pointInScene(model, point.instance, *hit);
    if (!isSamePlace(point, ray, finer)) continue;
    finer.seen_along = point.seen_along;
    return finer;
  }
  return std::nullopt;
}

std::optional<Ground> ViewedScene::groundBelow(const core::View& view, const glm::dvec3& point_model,
                                               const glm::dvec3& up) {
  const core::View scene_view = withNear(view);
  std::optional<Ground> highest;
  if (scene_.ground && up == scene_.up) {
    const double height = glm::dot(point_model + whole_.lattice.origin, up) - scene_.ground->height;
    if (height > 0) highest = Ground{height, 0};
  }
  for (const auto& model : models_) {
    for (size_t instance = 0; instance < model->instances.size(); ++instance) {
      const Placement& at = model->instances[instance];
      const glm::dvec3 from = model->toModel(instance, point_model);
      const glm::dvec3 model_up = glm::conjugate(at.rotation) * up;
      if (!core::distanceAlong({from, -model_up}, model->box())) continue;
      const core::CutProbe* const probe = model->probe(instance);
      if (probe == nullptr) continue;
      const auto ground = app::groundBelow(*probe, model->viewAt(instance, scene_view), from, model_up);
      if (ground && (!highest || ground->depth_model * at.scale < highest->depth_model))
        highest = Ground{ground->depth_model * at.scale, ground->uncertainty_model * at.scale};
    }
  }
  return highest;
}

}  // namespace lode::app
