#pragma once

#include <cstdint>

namespace lode::test {

/// Returns the number of seeds with which to test a property. With a sanitizer, which makes tests ten times
/// slower, returns a third.
#ifdef LODE_SANITIZED
constexpr uint32_t kSeeds = 4;
#else
constexpr uint32_t kSeeds = 12;
#endif

}  // namespace lode::test
