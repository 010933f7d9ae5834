#include "client/app/window/scene/picks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "client/app/window/scene/paint.h"
#include "client/render/passes/color_mode.h"

namespace lode::app {
namespace {

constexpr size_t kMostMeasures = 100;

std::string coordinates(const glm::dvec3& position, int decimals) {
  char text[160];
  std::snprintf(text, sizeof text, "%.*f %.*f %.*f", decimals, position.x, decimals, position.y, decimals,
                position.z);
  return text;
}

glm::dvec3 normalOf(const core::Hit& hit, double step) {
  std::array<glm::dvec3, 3> corners;
  for (int k = 0; k < 3; ++k)
    corners[k] =
        glm::dvec3(unpackPosition(hit.part->mesh->positions[hit.part->mesh->triangles[hit.triangle][k]])) *
        step;
  const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  const double length = glm::length(normal);
  return length > 0 ? normal / length : glm::dvec3(0);
}

}  // namespace

PickedPoint pointOf(const core::Hit& hit, const ModelSummary& model, const core::Cut& textured) {
  return {hit.position_model,
          model.lattice.origin + hit.position_model,
          false,
          false,
          hit.part->node,
          hit.part->lod,
          hit.part->error_px,
          model.lattice.step,
          paintAt(hit, textured),
          "",
          hit.part->error_model,
          0,
          0,
          {},
          normalOf(hit, model.lattice.step)};
}

int decimalsOf(double step) noexcept {
  return std::clamp(static_cast<int>(std::ceil(-std::log10(step))), 0, 12);
}

double uncertaintyOf(const PickedPoint& point) noexcept {
  return point.error + point.step * std::sqrt(3.0) / 2;
}

void Picks::clear() noexcept { before_ = std::exchange(current_.points, {}); }

void Picks::add(PickedPoint point) {
  before_ = current_.points;
  if (current_.points.size() >= mostPoints(current_.kind)) current_.points.erase(current_.points.begin());
  current_.points.push_back(std::move(point));
}

void Picks::nextKind() noexcept {
  current_.kind = static_cast<MeasureKind>((static_cast<size_t>(current_.kind) + 1) % kMeasureKindCount);
  std::vector<PickedPoint>& points = current_.points;
  const size_t most = mostPoints(current_.kind);
  if (points.size() > most) points.erase(points.begin(), points.end() - static_cast<ptrdiff_t>(most));
  before_ = points;
}

bool Picks::keep() {
  if (!valueOf(current_, {0, 1, 0}) || kept_.size() >= kMostMeasures) return false;
  kept_.push_back(current_);
  is_unsaved_ = true;
  clear();
  before_.clear();
  return true;
}

bool Picks::dropLast() noexcept {
  if (kept_.empty()) return false;
  kept_.pop_back();
  is_unsaved_ = true;
  return true;
}

std::vector<Measure> Picks::all() const {
  std::vector<Measure> all = kept_;
  if (valueOf(current_, {0, 1, 0})) all.push_back(current_);
  return all;
}

std::vector<Measure*> Picks::measures() {
  std::vector<Measure*> measures;
  for (Measure& measure : kept_) measures.push_back(&measure);
  measures.push_back(&current_);
  return measures;
}

std::vector<std::string> Picks::lines(const glm::dvec3& up, std::string_view unit) const {
  std::vector<std::string> lines;
  if (!current_.points.empty()) {
    const PickedPoint& last = current_.points.back();
    char text[160];
    lines.push_back(coordinates(last.position, decimalsOf(last.step)));
    if (!last.model.empty()) lines.push_back("model " + last.model);
    std::snprintf(text, sizeof text, "node %s, LOD %u, error %.2f px", render::nodeName(last.node).c_str(),
                  last.lod, static_cast<double>(last.error_px));
    lines.emplace_back(last.is_ground ? "the ground" : last.is_on_cut ? "the section" : text);
    if (const auto& colour = last.colour) {
      std::snprintf(text, sizeof text, "colour #%02x%02x%02x", colour->r, colour->g, colour->b);
      lines.emplace_back(text);
    }
  }
  for (const Measure& measure : all())
    lines.push_back(std::string(nameOf(measure.kind)) + " " + valueText(measure, up, unit));
  return lines;
}

}  // namespace lode::app
