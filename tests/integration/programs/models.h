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

/// Returns all models. Models made from scans exist only if LODESTREAM_TEST_DATA is set.
const std::vector<Model>& models();

/// Prints the name of the model in the messages of a failing test.
inline void PrintTo(const Model& model, std::ostream* out) { *out << model.name; }
inline std::string nameOf(const testing::TestParamInfo<Model>& model) { return model.param.name; }

/// Skips the running test, with the reason, if the model was not made.
#define LODE_REQUIRE_MODEL(model) \
  if (!(model).exists())          \
  GTEST_SKIP() << "no " << (model).store() << ": set LODESTREAM_TEST_DATA to a folder of scans"

}  // namespace lode::test
