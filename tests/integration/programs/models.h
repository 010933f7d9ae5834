#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace lode::test {

/// A model that tests/integration/make_models.sh has made.
struct Model {
  std::string name;
  std::filesystem::path input;
  bool is_closed = true;

  std::filesystem::path store() const;
  bool exists() const { return std::filesystem::exists(store()) && std::filesystem::exists(input); }
};

/// All of them; those made of scans exist only with LODESTREAM_TEST_DATA.
const std::vector<Model>& models();

/// What a failing test calls it.
inline void PrintTo(const Model& model, std::ostream* out) { *out << model.name; }
inline std::string nameOf(const testing::TestParamInfo<Model>& model) { return model.param.name; }

/// Skips the running test, saying why, if the model was not made.
#define LODE_REQUIRE_MODEL(model) \
  if (!(model).exists())          \
  GTEST_SKIP() << "no " << (model).store() << ": set LODESTREAM_TEST_DATA to a folder of scans"

}  // namespace lode::test
