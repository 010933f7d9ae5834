#pragma once

#include <cstdint>

namespace lode::test {

/// How many seeds show a property: a third where a sanitizer makes each take ten times as long.
#ifdef LODE_SANITIZED
constexpr uint32_t kSeeds = 4;
#else
constexpr uint32_t kSeeds = 12;
#endif

}  // namespace lode::test
