#pragma once

#include <cstdint>
#include <string>

#include "common/error.h"

namespace lode::proto {

/// @throws Error kProtocol, saying what is wrong, unless `good`.
inline void require(bool good, const char* what) {
  if (!good) throw Error(ErrorCode::kProtocol, std::string("a malformed message: ") + what);
}

/// @throws Error kLimit, naming what is too many and the limit.
inline void requireAtMost(uint64_t value, uint64_t limit, const char* what) {
  if (value > limit)
    throw Error(ErrorCode::kLimit, std::string("a message has ") + std::to_string(value) + " " + what +
                                       "; the limit is " + std::to_string(limit));
}

}  // namespace lode::proto
