#include "client/app/window/scene/picks.h"

#include <algorithm>
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
          ""};
}

void Picks::clear() noexcept { before_ = std::exchange(picks_, {}); }

void Picks::add(PickedPoint point) {
  before_ = picks_;
  if (picks_.size() == 2) picks_.erase(picks_.begin());
  picks_.push_back(std::move(point));
}

std::vector<std::string> Picks::lines() const {
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
  if (picks_.size() == 2) lines.push_back("distance " + distance());
  return lines;
}

std::string Picks::distance() const {
  if (picks_.size() != 2) return "";
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimalsOf(picks_.back().step),
                glm::distance(picks_.front().position, picks_.back().position));
  return text;
}

}  // namespace lode::app
