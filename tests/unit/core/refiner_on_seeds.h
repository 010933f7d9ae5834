#pragma once

#include <cstdint>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/core/scripted_client.h"

namespace lode::core::fixture {

/// Fixture with models that differ by their seed; several files contain its tests.
class RefinerOnSeeds : public testing::TestWithParam<uint32_t> {
 protected:
  SyntheticModel model_{{.seed = GetParam(), .empty_chance = GetParam() % 2 ? 0.1 : 0.0}};
  std::mt19937 random_{GetParam() * 7919};
};

}  // namespace lode::core::fixture
