#include "client/app/window/scene/viewed_scene.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

/// @return the error when the scene is made, before it opens; empty if there is none.
std::string errorOf(const std::string& models, const std::string& instances, MissingModels missing_models) {
  const test::WorkFolder work;
  const std::filesystem::path file = work / "scene.json";
  std::ofstream(file) << R"({"models": {)" << models << R"(}, "instances": [)" << instances << "]}";
  CommonOptions options;
  options.target = file.string();
  try {
    ViewedScene scene(options, missing_models);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

const std::string kModels = R"("a": "typo.ply", "b": "typo.lode", "away": "lode://127.0.0.1/rock")";
const std::string kOfTypos = R"({"model": "b"}, {"model": "a"}, {"model": "b"})";

TEST(ViewedScene, isRefusedBeforeItOpensIfNoInstanceHasAModel) {
  EXPECT_NE(errorOf(kModels, kOfTypos, MissingModels::kAllowed).find("models.\"b\": "), std::string::npos);
}

TEST(ViewedScene, mayLackAModelIfAnotherCanOpen) {
  EXPECT_EQ(errorOf(kModels, kOfTypos + R"(, {"model": "away"})", MissingModels::kAllowed), "");
}

TEST(ViewedScene, mayLackNoModelInAScreenshot) {
  EXPECT_NE(errorOf(kModels, R"({"model": "away"})", MissingModels::kRefused).find("models.\"a\": "),
            std::string::npos);
}

}  // namespace
}  // namespace lode::app
