#include "client/app/window/scene/named_viewer_content.h"

#include "client/app/cli/first_camera.h"
#include "client/app/cli/target.h"
#include "client/app/window/scene/viewed_model.h"
#include "client/app/window/scene/viewed_scene.h"

namespace lode::app {
namespace {

stream::StreamOptions streamOptions(const CommonOptions& common) {
  stream::StreamOptions options = common.streamOptions();
  options.engine.refine.hysteresis_factor = core::kHysteresisFactor;
  options.engine.prefetch = true;
  options.engine.session.awaits_model = true;
  return options;
}

}  // namespace

std::unique_ptr<ViewerContent> contentOf(const CommonOptions& common, Lacking lacking) {
  if (namesScene(common.target)) return std::make_unique<ViewedScene>(common, lacking);
  return std::make_unique<ViewedModel>(parseTarget(common.target), streamOptions(common),
                                       wantedFraming(common), common.timeout());
}

}  // namespace lode::app
