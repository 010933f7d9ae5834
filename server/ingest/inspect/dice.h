#pragma once

#include <cstdint>

#include "server/ingest/mesh/number_table.h"

namespace lode::ingest {

/// Pseudo-random numbers from 0 to 1, the same everywhere.
class Dice {
 public:
  explicit Dice(uint64_t seed) : state_(NumberTable::hash(seed + 1)) {}
  float roll() noexcept {
    state_ += 0x9e3779b97f4a7c15ULL;
    return static_cast<float>(NumberTable::hash(state_) >> 40) * 0x1p-24f;
  }

 private:
  uint64_t state_;
};

}  // namespace lode::ingest
