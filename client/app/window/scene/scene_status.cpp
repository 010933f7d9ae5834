#include "client/app/window/scene/scene_status.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace lode::app {

stream::StreamStatus sceneStatus(std::span<const ModelStatus> models, const core::View& scene_view) {
  stream::StreamStatus all;
  auto cut = std::make_shared<core::Cut>();
  cut->threshold_px = 0;
  cut->converged = all.settled = all.current = true;
  all.ended = !models.empty();
  bool is_shown = true, is_for_view = true;
  for (const auto& [one, view] : models) {
    all.counts += one.counts;
    all.limited = all.limited || one.limited;
    all.settled = all.settled && one.settled;
    all.current = all.current && one.current;
    all.exhausted = all.exhausted || one.exhausted;
    all.ended = all.ended && one.ended;
    if (all.failure.empty() || (all.failure_may_pass && !one.failure.empty() && !one.failure_may_pass)) {
      all.failure = one.failure;
      all.failure_remedy = one.failure_remedy;
      all.failure_may_pass = one.failure_may_pass;
    }
    if (all.trouble.empty()) {
      all.trouble = one.trouble;
      all.trouble_remedy = one.trouble_remedy;
    }
    is_shown = is_shown && one.view_cuts;
    if (!one.view_cuts) continue;
    cut->threshold_px = std::max(cut->threshold_px, one.cut->threshold_px);
    cut->max_error_px = std::max(cut->max_error_px, one.cut->max_error_px);
    cut->lost_tiles += one.cut->lost_tiles;
    cut->converged = cut->converged && one.cut->converged;
    is_for_view = is_for_view && one.cut->view == view;
  }
  if (is_for_view) cut->view = scene_view;
  if (is_shown) all.cut = std::move(cut);
  return all;
}

}  // namespace lode::app
