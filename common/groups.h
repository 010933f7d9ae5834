#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lode {

/// Union-find over the numbers from 0 to count - 1. The representative of a group is its smallest number. Not
/// thread safe.
class Groups {
 public:
  explicit Groups(size_t count) : towards_(count) { std::iota(towards_.begin(), towards_.end(), 0u); }

  uint32_t find(uint32_t i) noexcept {
    while (towards_[i] != i) i = towards_[i] = towards_[towards_[i]];
    return i;
  }
  /// Joins the groups of two numbers. @return true if the numbers were in different groups before.
  bool join(uint32_t a, uint32_t b) noexcept {
    a = find(a);
    b = find(b);
    towards_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<uint32_t> towards_;
};

}  // namespace lode
