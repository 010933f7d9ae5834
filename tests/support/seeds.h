#pragma once

#include <cstdint>

namespace lode::test {

/// Number of seeds with which tests check a property. Sanitizers make tests ten times slower, so they use a
/// third of the seeds.
#ifdef LODE_SANITIZED
constexpr uint32_t kSeeds = 4;
#else
constexpr uint32_t kSeeds = 12;
#endif

}  // namespace lode::test
