#pragma once

#include <string>
#include <string_view>

#include "client/web/core/web_model.h"

/// JSON between the page and the core; docs/browser.md lists the members. All functions are thread safe and
/// throw Error kInput if a text is not as documented.
namespace lode::web {

WebModelOptions parseOptions(std::string_view json);
CameraStart parseCameraStart(std::string_view json);
FrameInput parseFrame(std::string_view json);

std::string summaryJson(const ModelSummary& summary);
/// Returns the state of a model after WebModel::frame().
/// @param with_parts  true if the page does not know the current list of parts.
std::string frameJson(WebModel& model, const FrameInput& frame, bool with_parts);
std::string pickJson(const WebPick& pick);
/// Projects true coordinates [[x, y, z], ...] to [[x_px, y_px, is_in_front], ...].
std::string projectJson(const WebModel& model, std::string_view points);
std::string errorJson(std::string_view error, bool is_final);

}  // namespace lode::web
