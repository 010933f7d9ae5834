#include "client/app/cli/scene_file.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::app {
namespace {

const std::string kModels = R"("models": {"rock": "rock.lode", "tree": "lode://host/tree"})";

Scene parse(const std::string& instances, const std::string& more = "") {
  return parseScene("{" + kModels + ", \"instances\": [" + instances + "]" + more + "}", "scene.json");
}

std::string refusalOf(const std::string& text) {
  try {
    parseScene(text, "scene.json");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// The error must name the model, because a scene may have dozens.
TEST(SceneFile, namesTheModelOfAnError) {
  Scene scene;
  scene.models = {{"tree", "tree.lode"}, {"rock", "gone.lode"}};
  const Error error =
      ofSceneModel({ErrorCode::kIo, "gone.lode: no such file", Remedy::kModel}, "a.json", scene, 1);
  EXPECT_EQ(error.code(), ErrorCode::kIo);
  EXPECT_EQ(error.remedy(), Remedy::kModel);
  EXPECT_EQ(error.what(), std::string("a.json: models.\"rock\": gone.lode: no such file"));
}

/// Names come from an untrusted file and are printed to a terminal.
TEST(SceneFile, quotesANameInOneShortLineOfAscii) {
  EXPECT_EQ(quoted("rock"), R"("rock")");
  EXPECT_EQ(quoted("a\"b\n\x1b[31m\u00e9"), R"("a\"b\n\u001b[31m\u00e9")");
  EXPECT_EQ(quoted(std::string(64, 'a')), '"' + std::string(64, 'a') + '"');
  EXPECT_EQ(quoted(std::string(1000, 'a')), '"' + std::string(64, 'a') + "...\"");
  EXPECT_EQ(quoted(std::string(63, 'a') + "\u00e9 and more"), '"' + std::string(63, 'a') + "...\"");
}

TEST(SceneFile, placesModelsByNameWithDefaultsForOmittedFields) {
  const Scene scene = parse(R"({"model": "tree"}, {"model": "rock", "position": [1, 2, 3], "scale": 2})");
  ASSERT_EQ(scene.models.size(), 2u);
  EXPECT_EQ(scene.models[0].name, "rock");
  EXPECT_EQ(scene.models[0].target, "rock.lode");
  EXPECT_EQ(scene.models[1].target, "lode://host/tree");
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.instances[0].model, 1u);
  EXPECT_EQ(scene.instances[0].placement.scale, 1);
  EXPECT_EQ(scene.instances[1].placement.position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.instances[1].placement.scale, 2);
  EXPECT_FALSE(scene.ground || scene.sky);
  EXPECT_EQ(scene.up, glm::dvec3(0, 0, 1));
}

TEST(SceneFile, hasAGroundASkyAndAnAxisThatIsUp) {
  const Scene scene = parse(R"({"model": "rock"})",
                            R"(, "up": "-y", "ground": {"height": -2, "colour": "#0a0b0c"},
                               "sky": {"top": "#ffffff"})");
  EXPECT_EQ(scene.up, glm::dvec3(0, -1, 0));
  EXPECT_EQ(scene.ground->height, -2);
  EXPECT_EQ(scene.ground->colour_srgb, glm::u8vec3(10, 11, 12));
  EXPECT_EQ(scene.sky->top_srgb, glm::u8vec3(255));
  EXPECT_EQ(scene.sky->bottom_srgb, SceneSky().bottom_srgb);
}

TEST(SceneFile, refusesInvalidScenesAndNamesThePlace) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "not JSON"},
      {"{\n]", "not JSON at line 2, column 1"},
      {"[]", "the scene is not an object"},
      {R"({"models": {"a": "a.lode", "a": "b.lode"}, "instances": [{"model": "a"}]})",
       R"("a" appears twice)"},
      {R"({"models": {"a": "b.json"}, "instances": [{"model": "a"}]})", "models.\"a\" is itself a scene"},
      {R"({"models": {}, "instances": []})", "models must be an object with at least one model"},
      {"{" + kModels + "}", "instances must be a list"},
      {"{" + kModels + R"(, "instances": []})", "instances must be a list with at least one instance"},
      {"{" + kModels + R"(, "instances": [{}]})", "instances[0].model is missing"},
      {"{" + kModels + R"(, "instances": [{"model": "dog"}]})", "instances[0].model is not a name in models"},
      {"{" + kModels + R"(, "instances": [{"model": "rock", "positon": [0,0,0]}]})",
       R"(no member "positon")"},
      {"{" + kModels + R"(, "instances": [{"model": "rock", "a\nb\u009b": 1}]})",
       R"(no member "a\nb\u009b")"},
      {"{" + kModels + R"(, "instances": [{"model": "rock", "position": [0,0]}]})", "position"},
      {"{" + kModels + R"(, "instances": [{"model": "rock", "position": [1e13,0,0]}]})",
       "position must be from -1e+12 to 1e+12"},
      {"{" + kModels + R"(, "instances": [{"model": "rock", "scale": 0}]})",
       "scale must be from 1e-06 to 1e+06"},
      {"{" + kModels + R"(, "instances": [{"model": "rock", "scale": -1}]})",
       "scale must be from 1e-06 to 1e+06"},
      {"{" + kModels + R"(, "instances": [{"model": "rock", "axis": [0,0,1]}]})", "both axis and degrees"},
      {"{" + kModels + R"(, "instances": [{"model": "rock", "axis": [0,0,0], "degrees": 3}]})",
       "axis must not be zero"},
      {"{" + kModels + R"(, "instances": [{"model": "rock"}], "sky": {"top": "blue"}})", "sky.top"},
      {"{" + kModels + R"(, "instances": [{"model": "rock"}], "up": "w"})", "up is none of"}};
  for (const auto& [text, what] : cases) {
    const std::string refusal = refusalOf(text);
    EXPECT_NE(refusal.find(what), std::string::npos) << text << ": " << refusal;
    EXPECT_EQ(refusal.find("scene.json: "), 0u);
  }
}

TEST(SceneFile, hasNoMoreBytesModelsAndInstancesThanTheLimits) {
  EXPECT_NE(refusalOf(std::string(kMaxSceneBytes + 1, ' ')).find("bytes; the limit"), std::string::npos);
  std::string instances = R"({"model": "rock"})";
  for (size_t i = 1; i < kMaxSceneInstances; ++i) instances += R"(,{"model": "rock"})";
  EXPECT_EQ(parse(instances).instances.size(), kMaxSceneInstances);
  EXPECT_THROW(parse(instances + R"(,{"model": "rock"})"), Error);
  std::string models;
  for (size_t i = 0; i <= kMaxSceneModels; ++i)
    models += (i ? ",\"m" : "\"m") + std::to_string(i) + R"(": "a")";
  EXPECT_NE(refusalOf("{\"models\": {" + models + R"(}, "instances": [{"model": "m0"}]})").find("65 models"),
            std::string::npos);
}

TEST(SceneFile, transformsTheViewIntoTheFrameOfAPlacedModel) {
  const Scene scene =
      parse(R"({"model": "rock", "position": [10, -4, 2], "axis": [0, 0, 1], "degrees": 90, "scale": 2})");
  const Placement& placement = scene.instances[0].placement;
  const glm::dvec3 origin(100, 200, 300), point(101, 203, 305);
  const glm::dvec3 in_scene = placement.position + placement.rotation * (placement.scale * point);
  EXPECT_NEAR(glm::distance(in_scene, glm::dvec3(10 - 406, -4 + 202, 2 + 610)), 0, 1e-9);
  core::View view;
  view.eye_model = in_scene + glm::dvec3(0, 8, 0);
  view.forward = {0, -1, 0};
  view.up = {0, 0, 1};
  view.near_model = 0.5;
  const core::View seen = viewFrom(view, placement, origin);
  const double away = glm::distance(seen.eye_model, point - origin);
  EXPECT_NEAR(away, 4, 1e-9) << "a model of twice the size is half as far, in its own units";
  EXPECT_NEAR(glm::distance(seen.eye_model + away * seen.forward, point - origin), 0, 1e-9);
  EXPECT_EQ(seen.near_model, 0.25);
  EXPECT_NEAR(glm::dot(seen.up, glm::dvec3(0, 0, 1)), 1, 1e-12);
}

TEST(SceneFile, wrapsASingleModelInAScene) {
  const Scene scene = sceneOf("lode://127.0.0.1/rock");
  EXPECT_TRUE(scene.is_single_model);
  ASSERT_EQ(scene.models.size(), 1u);
  EXPECT_EQ(scene.models[0].target, "lode://127.0.0.1/rock");
  ASSERT_EQ(scene.instances.size(), 1u);
  const Error error(ErrorCode::kIo, "gone.lode: no such file");
  EXPECT_EQ(ofSceneModel(error, "gone.lode", scene, 0).what(), std::string(error.what()));
}

/// Pictures of a single model must not depend on rounding, wherever its lattice lies.
TEST(SceneFile, keepsTheViewOfASingleModelExactly) {
  const glm::dvec3 origin(4'512'345.1, -312'345.7, 33.3), eye_model(0.1, 7.3, -2.7);
  core::View view;
  view.forward = glm::normalize(glm::dvec3(1, -2, 0.3));
  view.up = glm::normalize(glm::cross(view.forward, glm::dvec3(0.3, 0.1, -2)));
  view.eye_model = eye_model;
  core::View expected = view;
  EXPECT_EQ(viewFrom(view, {.position = -origin}, origin), expected) << "in the model's frame";
  view.eye_model = eye_model + origin;
  expected.eye_model = view.eye_model - origin;
  EXPECT_EQ(viewFrom(view, {}, origin), expected) << "in true coordinates";
}

}  // namespace
}  // namespace lode::app
