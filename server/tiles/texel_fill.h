#pragma once

#include <vector>

#include "common/image/image.h"

namespace lode::tiles {

/// Gives unknown texels the colours of known texels near them, so that filters and coarser levels mix no
/// foreign colour into known texels. Leaves alpha unchanged.
/// @param is_known  one flag per texel.
/// Source: Gortler et al., The Lumigraph, 1996 (pull-push).
void fillUnknown(Image& image, const std::vector<bool>& is_known);

}  // namespace lode::tiles
