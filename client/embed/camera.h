#pragma once

#include "client/core/view/view.h"
#include "client/embed/lodestream.h"
#include "common/codec/model_summary.h"

namespace lode::embed {

/// The C face's camera in the model's frame. @throws Error kUsage if it is none.
core::View toView(const lodestream_view& view, const ModelSummary& model);

}  // namespace lode::embed
