#pragma once

#include <string_view>

#include "client/core/view/view.h"

namespace lode::app {

/// For people who see nothing, or a dot: what has become of the model, and the key that helps. Empty where it
/// can be seen.
std::string_view lostSightText(const core::ModelBox& model, const core::View& view);

}  // namespace lode::app
