#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/synthetic_store.h"

namespace lode::test {

inline std::vector<char> readFile(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void writeFile(const std::filesystem::path& path, const std::vector<char>& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// A closed model with three levels and several pages.
inline SyntheticModel closedModel(AttributeSet attributes = {}) {
  return makeModel(makeSphere(24, 16, {.attributes = attributes, .extent = 4000, .seed = 7}));
}

/// The smallest model with two levels.
inline SyntheticModel smallModel() {
  return makeModel(makeSphere(5, 4, {.attributes = {}, .extent = 4000}), {.leaf_triangles = 12});
}

/// Returns the error's message, or "" if there is no error.
template <typename Action>
std::string messageOf(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace lode::test
