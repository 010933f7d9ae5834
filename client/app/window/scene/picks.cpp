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

/// Returns the number of decimals that resolves a lattice step. More decimals would be meaningless.
int decimalsOf(double step) { return std::clamp(static_cast<int>(std::ceil(-std::log10(step))), 0, 12); }

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

double uncertaintyOf(const PickedPoint& point) noexcept {
  return point.error + point.step * std::sqrt(3.0) / 2;
}

void Picks::clear() noexcept { before_ = std::exchange(picks_, {}); }

void Picks::add(PickedPoint point) {
  before_ = picks_;
  if (picks_.size() == 2) picks_.erase(picks_.begin());
  picks_.push_back(std::move(point));
}

std::vector<std::string> Picks::lines(std::string_view unit) const {
  if (picks_.empty()) return {};
  const PickedPoint& last = picks_.back();
  const int decimals = decimalsOf(last.step);
  char text[160];
  std::vector<std::string> lines{coordinates(last.position, decimals)};
  if (!last.model.empty()) lines.push_back("model " + last.model);
  std::snprintf(text, sizeof text, "node %s, LOD %u, error %.2f px", render::nodeName(last.node).c_str(),
                last.lod, static_cast<double>(last.error_px));
  lines.emplace_back(last.is_ground ? "the ground" : text);
  if (const auto& colour = last.colour) {
    std::snprintf(text, sizeof text, "colour #%02x%02x%02x", colour->r, colour->g, colour->b);
    lines.emplace_back(text);
  }
  if (picks_.size() == 2) lines.push_back("distance " + distance(unit));
  return lines;
}

std::string Picks::distance(std::string_view unit) const {
  if (picks_.size() != 2) return "";
  const double off = uncertaintyOf(picks_.front()) + uncertaintyOf(picks_.back());
  // Two significant digits of the uncertainty, but no more decimals than the lattice resolves.
  const int decimals = std::min(decimalsOf(picks_.back().step),
                                std::clamp(1 - static_cast<int>(std::floor(std::log10(off))), 0, 12));
  char text[128];
  std::snprintf(text, sizeof text, "%.*f \u00b1 %.*f", decimals,
                glm::distance(picks_.front().position, picks_.back().position), decimals, off);
  return unit.empty() ? text : text + (" " + std::string(unit));
}

}  // namespace lode::app
