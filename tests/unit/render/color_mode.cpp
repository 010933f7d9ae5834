#include "client/render/passes/color_mode.h"

#include <cmath>
#include <numeric>
#include <set>

#include "client/render/passes/light.h"
#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

using render::ColorMode;

render::DrawItem partOf(NodeKey node, uint32_t lod = 0, float error_rad = 0) {
  render::DrawItem part;
  part.node = node;
  part.lod = lod;
  part.error_rad = error_rad;
  return part;
}

/// Returns a square of 1000 units as a grid of squares, each of two triangles.
std::vector<Mesh> gridOf(uint32_t side, glm::u8vec4 colour) {
  std::vector<Mesh> meshes;
  const uint32_t size = 1000 / side;
  for (uint32_t i = 0; i < side * side; ++i)
    meshes.push_back(squareAt(i % side * size, i / side * size, 0, size, colour));
  return meshes;
}

class Shown : public GlTest {
 protected:
  static render::DrawStyle showing(ColorMode show) {
    render::DrawStyle style = magentaBehind();
    style.show = show;
    return style;
  }

  /// Returns the green values in the middle of a picture of a grid, whose squares have a side of `side_px`.
  static std::multiset<int> greensOf(uint32_t side, double side_px, ColorMode show, glm::u8vec4 colour) {
    const double distance = 1000.0 / side * kHeightPx / (2 * std::tan(core::View().fov_y_rad / 2) * side_px);
    render::DrawStyle style = magentaBehind();
    style.show = show;
    const render::Image image =
        drawMeshes(gridOf(side, colour), 1, lookAt({503, 507, distance}, {503, 507, 0}), style);
    std::multiset<int> greens;
    for (uint32_t x = kWidthPx / 2 - 15; x < kWidthPx / 2 + 15; ++x)
      for (uint32_t y = kHeightPx / 2 - 15; y < kHeightPx / 2 + 15; ++y) greens.insert(image.pixel(x, y)[1]);
    return greens;
  }
};

const core::View kBeforeASquare = lookAt({500, 500, 800}, {500, 500, 0});

TEST_F(Shown, unlitIsThePaintAlone) {
  const Mesh square = squareAt(0, 0, 0, 1000, {200, 100, 30, 255});
  const render::Image image = drawMeshes({square}, 1, kBeforeASquare, showing(ColorMode::kUnlit));
  const uint8_t* middle = image.pixel(kWidthPx / 2, kHeightPx / 2);
  EXPECT_NEAR(middle[0], 200, 1);
  EXPECT_NEAR(middle[1], 100, 1);
  EXPECT_NEAR(middle[2], 30, 1);
}

TEST_F(Shown, normalsAreColoursOfTheModelsAxes) {
  const Mesh square = squareAt(0, 0, 0, 1000, {255, 255, 255, 255});
  for (const bool is_front : {true, false}) {
    const core::View view = is_front ? kBeforeASquare : lookAt({500, 500, -800}, {500, 500, 0});
    const render::Image image = drawMeshes({square}, 1, view, showing(ColorMode::kNormals));
    const uint8_t* middle = image.pixel(kWidthPx / 2, kHeightPx / 2);
    EXPECT_NEAR(middle[0], 128, 3);
    EXPECT_NEAR(middle[1], 128, 3);
    EXPECT_NEAR(middle[2], is_front ? 255 : 0, 3);
  }
}

double meanOf(const std::multiset<int>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

TEST_F(Shown, wireframeHasDarkEdgesOverTheLitSurfaceWithoutHiddenLines) {
  std::vector<Mesh> meshes{squareAt(0, 0, 500, 1000, {255, 255, 255, 255})};
  for (const Mesh& behind : gridOf(20, {255, 255, 255, 255})) meshes.push_back(behind);
  const core::View view = lookAt({500, 500, 1300}, {500, 500, 0});
  const render::Image image = drawMeshes(meshes, 1, view, showing(ColorMode::kWireframe));
  const render::Image lit = drawMeshes({meshes.front()}, 1, view, showing(ColorMode::kSurface));
  std::set<int> row;  // crosses the diagonal in the middle
  for (uint32_t x = kWidthPx / 2 + 10; x < kWidthPx / 2 + 40; ++x)
    row.insert(image.pixel(x, kHeightPx / 2)[1]);
  EXPECT_LE(*row.rbegin() - *row.begin(), 3) << "lines of what is behind";
  EXPECT_NEAR(*row.begin(), lit.pixel(kWidthPx / 2 + 20, kHeightPx / 2)[1], 25) << "the lit surface";
  int darkest = 255;
  for (uint32_t x = kWidthPx / 2 - 3; x < kWidthPx / 2 + 3; ++x)
    darkest = std::min(darkest, int{image.pixel(x, kHeightPx / 2)[1]});
  EXPECT_LT(darkest, *row.begin() - 100) << "the diagonal";
}

TEST_F(Shown, wireframeHasEdgesAndSurfaceAtAnyDensityOfTriangles) {
  const glm::u8vec4 white(255, 255, 255, 255), dark(20, 20, 20, 255);
  for (const glm::u8vec4 colour : {white, dark}) {
    for (const double side_px : {60.0, 24.0, 12.0, 8.0}) {
      const auto greens = greensOf(20, side_px, ColorMode::kWireframe, colour);
      EXPECT_GT(*greens.rbegin() - *greens.begin(), 30) << "edges of " << side_px << " px";
    }
    for (const double side_px : {4.0, 2.0, 1.0}) {
      const double mean = meanOf(greensOf(100, side_px, ColorMode::kWireframe, colour));
      const double between = *greensOf(20, 60, ColorMode::kWireframe, colour).rbegin();
      EXPECT_GT(mean, between * 0.6) << side_px << ": the surface stays visible";
      EXPECT_LT(mean, between * 0.95) << side_px << ": edges darken it";
    }
  }
}

TEST_F(Shown, whiteInTheSunKeepsItsShading) {
  Mesh sphere = makeSphere(48, 24, {.attributes = {AttributeSet::kNormal}, .bump = 0});
  sphere.attributes.bits |= AttributeSet::kColour;
  for (VertexAttributes& attributes : sphere.vertex_attributes) attributes.colour = glm::u8vec4(255);
  const render::Image image = drawMeshes({sphere}, 1, lookAt({2048, 2048, 9000}, {2048, 2048, 2048}));
  std::set<int> greens;
  for (uint32_t y = 0; y < image.height_px; ++y)
    for (uint32_t x = 0; x < image.width_px; ++x)
      if (!showsMagenta(image.pixel(x, y))) greens.insert(image.pixel(x, y)[1]);
  EXPECT_LT(*greens.rbegin(), 255);
  EXPECT_GT(greens.size(), 60u);
}

TEST_F(Shown, exposureBrightensDarkSurfaces) {
  const Mesh square = squareAt(0, 0, 0, 1000, {40, 40, 40, 255});
  const auto brightness = [&](float exposure) {
    render::DrawStyle style = magentaBehind();
    style.exposure = exposure;
    const render::Image image = drawMeshes({square}, 1, kBeforeASquare, style);
    return int{image.pixel(kWidthPx / 2, kHeightPx / 2)[1]};
  };
  EXPECT_GT(brightness(4), 1.6 * brightness(1));  // sRGB of four times the light
}

TEST_F(Shown, partsHaveTheColoursOfTheirLegend) {
  const Mesh square = squareAt(0, 0, 0, 1000, {255, 0, 0, 255});
  const auto drawn = [&](ColorMode show) {
    const render::Image image = drawMeshes({square}, 1, kBeforeASquare, showing(show));
    const uint8_t* pixel = image.pixel(kWidthPx / 2, 75);
    return glm::ivec3(pixel[0], pixel[1], pixel[2]);
  };
  const render::DrawItem first = partOf(NodeKey{8});
  for (const ColorMode show : {ColorMode::kDepths, ColorMode::kLods, ColorMode::kErrors}) {
    const glm::ivec3 expected(colourOf(show, first, 1)), pixel = drawn(show);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) EXPECT_EQ(expected[i] > expected[j] + 20, pixel[i] > pixel[j] + 20);
  }
}

TEST(ShownColours, haveNamesThatAreReadBack) {
  for (const render::ColorModeTraits& mode : render::colorModes()) {
    EXPECT_EQ(render::colorModeNamed(mode.name), mode.mode);
    EXPECT_NE(render::colorModeNames().find(mode.name), std::string::npos);
  }
  EXPECT_FALSE(render::colorModeNamed("nothing"));
}

TEST(ShownColours, tellErrorsAboveTheThresholdFromThoseBelow) {
  const auto colour = [](float error_rad) {
    return colourOf(ColorMode::kErrors, partOf(kRootKey, 0, error_rad), 2);
  };
  EXPECT_NE(colour(2.01f), colour(2));
  EXPECT_EQ(colour(2.01f), colour(50));
  EXPECT_NE(colour(0.1f), colour(2));
  const auto legend = legendOf(ColorMode::kErrors, {}, 2);
  EXPECT_EQ(legend.back().meaning, "above 2 px");
  EXPECT_EQ(legend.back().colour, colour(50));
  EXPECT_EQ(legend[legend.size() - 2].meaning, "up to 2 px");
}

TEST(ShownColours, areExplainedForTheDepthsAndLodsThatAreDrawn) {
  const std::vector<render::DrawItem> drawn{partOf(kRootKey.child(1).child(2), 3), partOf(kRootKey.child(1)),
                                            partOf(kRootKey.child(3))};
  const auto depths = legendOf(ColorMode::kDepths, drawn, 1), lods = legendOf(ColorMode::kLods, drawn, 1);
  ASSERT_EQ(depths.size(), 2u);
  EXPECT_EQ(depths[0].meaning, "depth 1, the coarsest shown");
  EXPECT_EQ(depths[1].meaning, "depth 2, the finest shown");
  EXPECT_NE(depths[0].colour, depths[1].colour);
  ASSERT_EQ(lods.size(), 2u);
  EXPECT_EQ(lods[0].meaning, "LOD 0, the finest of its node");
  EXPECT_EQ(lods[1].meaning, "LOD 3, the coarsest shown");
  EXPECT_EQ(legendOf(ColorMode::kDepths, std::span(drawn).last(1), 1)[0].meaning, "depth 1");
  EXPECT_TRUE(legendOf(ColorMode::kSurface, drawn, 1).empty());
}

TEST(ShownColours, areExplainedForTheNodesThatAreDrawn) {
  const std::vector<render::DrawItem> drawn{partOf(kRootKey.child(1).child(2)), partOf(kRootKey.child(3)),
                                            partOf(kRootKey.child(3))};
  const std::vector<render::LegendEntry> expected{
      {colourOf(ColorMode::kNodes, drawn[1], 1), "node root/3"},
      {colourOf(ColorMode::kNodes, drawn[0], 1), "node root/1/2"}};
  EXPECT_EQ(legendOf(ColorMode::kNodes, drawn, 1), expected);
}

TEST(ShownColours, differBetweenInstancesAndNameThem) {
  std::vector<render::DrawItem> drawn{partOf(kRootKey), partOf(kRootKey), partOf(kRootKey)};
  drawn[0].instance = {7, "rock"};
  drawn[1].instance = drawn[2].instance = {8, "tree"};
  const std::vector<render::LegendEntry> expected{
      {colourOf(ColorMode::kNodes, drawn[0], 1, 7), "rock, node root"},
      {colourOf(ColorMode::kNodes, drawn[1], 1, 8), "tree, node root"}};
  EXPECT_EQ(legendOf(ColorMode::kNodes, drawn, 1), expected);
  EXPECT_NE(expected[0].colour, expected[1].colour);
}

TEST(ShownColours, areExplainedForEachModelBeforeASecondInstance) {
  std::vector<render::DrawItem> drawn;
  for (uint32_t model = 0; model < 2; ++model)
    for (uint32_t nth = 1; nth <= 20; ++nth)
      drawn.emplace_back(partOf(kRootKey)).instance = {100 * model + nth, model == 0 ? "rock" : "tree", nth};
  const auto legend = legendOf(ColorMode::kNodes, drawn, 1);
  EXPECT_EQ(legend[0].meaning, "rock 1, node root");
  EXPECT_EQ(legend[1].meaning, "tree 1, node root");
  EXPECT_EQ(legend[2].meaning, "rock 2, node root");
  EXPECT_EQ(legend[1].colour, colourOf(ColorMode::kNodes, drawn[20], 1, 101));
}

TEST(ShownColours, explainTheSixDirectionsOfNormals) {
  const auto legend = legendOf(ColorMode::kNormals, {}, 1);
  ASSERT_EQ(legend.size(), 6u);
  EXPECT_EQ(legend[5], (render::LegendEntry{{128, 128, 0}, "faces -z"}));
}

TEST(ShownColours, haveATextExplanationInUnlitAndWireframeModes) {
  for (const ColorMode show : {ColorMode::kUnlit, ColorMode::kWireframe})
    EXPECT_FALSE(traitsOf(show).explanation.empty());
  EXPECT_TRUE(traitsOf(ColorMode::kSurface).explanation.empty());
}

TEST(ShownColours, areExplainedForTheFirstNodesAndTheOthersAreCounted) {
  std::vector<render::DrawItem> drawn;
  for (unsigned i = 0; i < 64; ++i) drawn.push_back(partOf(kRootKey.child(i / 8).child(i % 8)));
  const auto legend = legendOf(ColorMode::kNodes, drawn, 1);
  EXPECT_EQ(legend.size(), 17u);
  EXPECT_EQ(legend.back().meaning, "and 48 more nodes, each in its own colour");
}

TEST(Light, comesFromTheLeftAboveAndBehindOfALevelCamera) {
  const render::Light light = render::lightFor(lookAt({0, 0, 5}, {0, 0, 0}), {0, 1, 0});
  EXPECT_LT(light.to_sun.x, -0.3f);
  EXPECT_GT(light.to_sun.y, 0.3f);
  EXPECT_GT(light.to_sun.z, 0.3f);
}

TEST(Light, standsAboveTheModelHoweverTheCameraIsTilted) {
  for (const glm::dvec3 eye : {glm::dvec3(0, 5, 5), glm::dvec3(3, -5, 1), glm::dvec3(0.01, 5, 0)}) {
    const render::Light light = render::lightFor(lookAt(eye, {0, 0, 0}), {0, 3, 0});
    EXPECT_NEAR(glm::length(light.to_sun), 1, 1e-5);
    EXPECT_NEAR(glm::dot(light.to_sun, light.up), 0.78, 0.01);
  }
}

TEST(Light, existsForACameraOnItsSide) {
  const render::Light light = render::lightFor(lookAt({0, 0, 5}, {0, 0, 0}, {1, 0, 0}), {0, 1, 0});
  EXPECT_NEAR(glm::length(light.to_sun), 1, 1e-5);
  EXPECT_GT(light.to_sun.z, 0.3f);
}

TEST_F(Shown, agesHaveColoursThatCoolDownAndAreAllInTheLegend) {
  const auto colourAt = [](float age_s) {
    render::DrawItem part;
    part.age_s = age_s;
    return colourOf(ColorMode::kAges, part, 1);
  };
  const auto legend = legendOf(ColorMode::kAges, {}, 1);
  ASSERT_EQ(legend.size(), 5u);
  const float ages_s[] = {0.25f, 1, 4, 16, 16.1f};
  for (size_t i = 0; i < legend.size(); ++i) EXPECT_EQ(colourAt(ages_s[i]), legend[i].colour);
  EXPECT_EQ(legend.back().meaning, "older");
}

TEST_F(Shown, agesStopToChangeOnceAllIsOld) {
  const auto cut = cutOf(std::vector{squareAt(0, 0, 0, 1000, {255, 255, 255, 255})});
  render::Renderer renderer;
  renderer.show(cut);
  renderer.uploadInRenderThread({.wait = true});
  const render::Framebuffer target(kWidthPx, kHeightPx);
  renderer.draw(kBeforeASquare, target, showing(ColorMode::kAges), {.now_s = 100});
  EXPECT_TRUE(renderer.ageing());
  renderer.draw(kBeforeASquare, target, showing(ColorMode::kAges), {.now_s = 101 + render::kOldS});
  EXPECT_FALSE(renderer.ageing());
  target.resolve();
  const render::Image image = target.readPixels();
  const uint8_t* middle = image.pixel(kWidthPx / 2, kHeightPx / 2);
  EXPECT_GT(middle[2], middle[0]) << "the last colour is blue";
}

}  // namespace
}  // namespace lode::test
