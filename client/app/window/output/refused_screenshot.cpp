#include "client/app/window/output/refused_screenshot.h"

#include "client/app/cli/not_converged.h"
#include "common/error.h"

namespace lode::app {

void refuseScreenshot(const ViewedScene& scene, const CommonOptions& options) {
  if (scene.overBudget())
    throw Error(ErrorCode::kLimit, options.target +
                                       ": the GPU has no room for all of the screenshot; allow more with "
                                       "--memory-budget, or a larger error with --pixels");
  refuseUnconverged("the screenshot's view", scene.status(), options);
}

}  // namespace lode::app
