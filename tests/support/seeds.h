#pragma once

#include <cstdint>

namespace lode::test {

/// Number of seeds with which tests check a property. With a sanitizer, which makes tests ten times slower, a
/// third suffices.
#ifdef LODE_SANITIZED
constexpr uint32_t kSeeds = 4;
#else
constexpr uint32_t kSeeds = 12;
#endif

}  // namespace lode::test
