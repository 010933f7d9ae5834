#pragma once

#include <memory>

#include "client/core/cut.h"

/// What the C face hands out.
struct lodestream_cut {
  std::shared_ptr<const lode::core::Cut> cut;
  double lattice_step = 1;
};
