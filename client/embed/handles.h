#pragma once

#include <cstdint>
#include <memory>

#include "client/core/lod/cut.h"
#include "common/codec/model_summary.h"

/// What the C face hands out.
struct lodestream_cut {
  std::shared_ptr<const lode::core::Cut> cut;
  lode::ModelSummary model;
  uint64_t serial = 0;  // by its stream
};
