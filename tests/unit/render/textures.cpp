#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "client/core/textures/tile.h"
#include "gl_fixture.h"
#include "tests/support/texture_images.h"

namespace lode::test {
namespace {

/// A textured square of 4096 steps per side in the plane z = 0, seen from the front; u grows with x, v with
/// y. Texture codes go from 0 to 2^15.
class TexturedSquare : public GlTest {
 protected:
  static constexpr double kSide = 4096;

  static Mesh square(glm::u8vec4 colour, uint8_t attributes) {
    Mesh mesh = squareAt(0, 0, 0, static_cast<uint32_t>(kSide), colour);
    mesh.attributes.bits = attributes;
    for (size_t i = 0; i < 4; ++i)
      mesh.vertex_attributes[i].texture = {i == 1 || i == 2 ? 32768 : 0, i >= 2 ? 32768 : 0};
    return mesh;
  }

  /// A view from above a point with pixels of size `pixel_model`.
  static core::View above(glm::dvec2 point, double pixel_model) {
    core::View view = lookAt({point, 1}, {point, 0});
    view.eye_model.z = pixel_model * view.height_px / (2 * std::tan(view.fov_y_rad / 2));
    return view;
  }

  /// Position of a pixel's centre on the square.
  static glm::dvec2 pointAt(const core::View& view, uint32_t x, uint32_t y) {
    const double pixel_model = view.eye_model.z * 2 * std::tan(view.fov_y_rad / 2) / view.height_px;
    return glm::dvec2(view.eye_model) +
           pixel_model * glm::dvec2(x + 0.5 - view.width_px / 2.0, view.height_px / 2.0 - y - 0.5);
  }

  void wear(const TextureImages& images, glm::dvec2 uv_origin = {0, 0}, int32_t exponent = 1) {
    auto set = std::make_shared<TextureSet>();
    set->uv_origin = uv_origin;
    set->uv_scale_exponent = exponent;
    set->textures.push_back(images.texture());
    set_ = set;
    tiles_.clear();
    images.forEachTile([&](uint32_t level, uint32_t x, uint32_t y) {
      TileImage image = images.tile(level, x, y);
      if (level + 1 == levelCount(images.texture())) core::makeTail(image);
      tiles_.push_back({{level, 0, y, x}, std::make_shared<const TileImage>(std::move(image))});
    });
  }

  std::shared_ptr<const core::Cut> cutOfAllTiles() const {
    auto cut = std::make_shared<core::Cut>();
    cut->textures = set_;
    cut->tiles = tiles_;
    return cut;
  }

  render::Image drawSquare(const core::View& view, glm::u8vec4 colour = glm::u8vec4(255),
                           uint8_t attributes = AttributeSet::kTexture, int samples = 4) {
    render::Renderer renderer;
    auto cut = std::make_shared<core::Cut>(*cutOf({square(colour, attributes)}));
    cut->textures = set_;
    cut->tiles = tiles_;
    renderer.show(cut);
    renderer.uploadInRenderThread({.wait = true});
    EXPECT_TRUE(renderer.upToDate());
    render::DrawStyle style = magentaBehind();
    style.show = shown_;
    return draw(renderer, view, style, samples);
  }

  /// Lit white and lit black at each pixel.
  void drawReferences(const core::View& view) {
    white_ = drawSquare(view, glm::u8vec4(255), AttributeSet::kColour);
    black_ = drawSquare(view, glm::u8vec4(0, 0, 0, 255), AttributeSet::kColour);
  }

  static double toLinear(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
  }
  static double toSrgb(double linear) {
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  }

  /// The pixel value of a lit surface of colour `linear`.
  double lit(double linear, uint32_t x, uint32_t y, int channel) const {
    const double most = toLinear(white_.pixel(x, y)[channel] / 255.0);
    const double least = toLinear(black_.pixel(x, y)[channel] / 255.0);
    return 255 * toSrgb(least + (most - least) * linear);
  }

  std::shared_ptr<const TextureSet> set_;
  std::vector<core::ResidentTile> tiles_;
  render::Image white_, black_;
  render::ColorMode shown_ = render::ColorMode::kSurface;
};

/// An image in which every texel has a different colour.
TextureImages noise(uint32_t width, uint32_t height) {
  std::mt19937 random(5);
  return {width, height, [&](uint32_t, uint32_t) {
            const auto bits = static_cast<uint32_t>(random());
            return glm::u8vec4(bits & 255, bits >> 8 & 255, bits >> 16 & 255, 255);
          }};
}

/// Colour of the square of 64 x 64 texels that a texel lies in.
glm::u8vec4 checkered(uint32_t x, uint32_t y) {
  const uint32_t colour = (x / 64 * 3 + y / 64 * 5) % 7 + 1;
  return {(colour & 1) * 255, (colour >> 1 & 1) * 255, (colour >> 2) * 255, 255};
}

struct Place {
  const char* name;
  glm::dvec2 uv;
};

class TexturedSquareAt : public TexturedSquare, public testing::WithParamInterface<Place> {};

/// Reference: bilinear filtering of a repeating level.
glm::dvec3 sampleByHand(const TileImage& whole, glm::dvec2 uv) {
  const glm::dvec2 size = glm::dvec2(whole.size) - 2.0 * kTileGutterPx;
  const glm::dvec2 place = glm::dvec2(uv.x, 1 - uv.y) * size - 0.5;
  const glm::dvec2 corner = glm::floor(place), part = place - corner;
  glm::dvec3 sum(0);
  for (const glm::dvec2 step : {glm::dvec2(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
    const glm::dvec2 texel = glm::mod(corner + step, size) + double{kTileGutterPx};
    const glm::u8vec4 colour =
        whole.texels[static_cast<size_t>(texel.y) * whole.size.x + static_cast<size_t>(texel.x)];
    const glm::dvec2 weights = glm::mix(1.0 - part, part, step);
    for (int channel = 0; channel < 3; ++channel) {
      const double srgb = colour[channel] / 255.0;
      sum[channel] +=
          weights.x * weights.y * (srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
    }
  }
  return sum;
}

TEST_P(TexturedSquareAt, showsTheTexelsOfTheFinestLevelFilteredWithoutASeam) {
  const uint32_t width = 1100, height = 700;
  const TextureImages images = noise(width, height);
  wear(images, {-0.5, -0.5}, 2);  // codes 0..2^15 are -0.5 .. 1.5
  TileImage whole{{width + 2 * kTileGutterPx, height + 2 * kTileGutterPx}, {}, {}};
  whole.texels.resize(size_t{whole.size.x} * whole.size.y);
  for (uint32_t y = 0; y < tilesDown(images.texture(), 0); ++y)
    for (uint32_t x = 0; x < tilesAcross(images.texture(), 0); ++x) {
      const TileImage tile = images.tile(0, x, y);
      for (uint32_t row = 0; row < tile.size.y; ++row)
        std::copy_n(tile.texels.begin() + row * tile.size.x, tile.size.x,
                    whole.texels.begin() + (y * kTileInnerPx + row) * whole.size.x + x * kTileInnerPx);
    }

  const glm::dvec2 point = (GetParam().uv + 0.5) / 2.0 * kSide;
  const core::View view = above(point, kSide / 2 / width / 16);  // 16 pixels a texel
  drawReferences(view);
  const render::Image image = drawSquare(view);
  double worst = 0;
  for (uint32_t y = 0; y < image.height_px; y += 3)
    for (uint32_t x = 0; x < image.width_px; ++x) {
      const glm::dvec2 uv = pointAt(view, x, y) / kSide * 2.0 - 0.5;
      const glm::dvec3 expected = sampleByHand(whole, uv);
      for (int channel = 0; channel < 3; ++channel)
        worst = std::max(worst, std::abs(lit(expected[channel], x, y, channel) - image.pixel(x, y)[channel]));
    }
  EXPECT_LE(worst, 8);
}

INSTANTIATE_TEST_SUITE_P(Of, TexturedSquareAt,
                         testing::Values(Place{"TheMiddle", {0.4, 0.6}},
                                         Place{"ABorderBetweenTiles", {508.0 / 1100, 0.5}},
                                         Place{"ACornerOfFourTiles", {508.0 / 1100, 1 - 508.0 / 700}},
                                         Place{"TheRightRim", {1, 0.3}}, Place{"TheTopRim", {0.7, 1}},
                                         Place{"TheBottomLeftCorner", {0, 0}},
                                         Place{"ARepeat", {-0.25, 1.25}}),
                         [](const auto& place) { return place.param.name; });

/// Counts pixels inside one square of the checkered texture that show another colour.
int wrongPixels(const render::Image& image, const core::View& view, double side, double margin_texels,
                const std::function<double(double, uint32_t, uint32_t, int)>& lit,
                const std::function<glm::dvec2(const core::View&, uint32_t, uint32_t)>& point_at,
                int& compared) {
  int wrong = 0;
  for (uint32_t y = 0; y < image.height_px; ++y)
    for (uint32_t x = 0; x < image.width_px; ++x) {
      const glm::dvec2 uv = point_at(view, x, y) / side;
      if (glm::any(glm::lessThan(uv, glm::dvec2(0.01))) || glm::any(glm::greaterThan(uv, glm::dvec2(0.99))))
        continue;
      const glm::dvec2 texel(uv.x * 2048, (1 - uv.y) * 2048), in_square = glm::mod(texel, glm::dvec2(64));
      if (glm::any(glm::lessThan(in_square, glm::dvec2(margin_texels))) ||
          glm::any(glm::greaterThan(in_square, glm::dvec2(64 - margin_texels))))
        continue;
      ++compared;
      const glm::u8vec4 colour = checkered(static_cast<uint32_t>(texel.x), static_cast<uint32_t>(texel.y));
      for (int channel = 0; channel < 3; ++channel)
        if (std::abs(lit(colour[channel] / 255.0, x, y, channel) - image.pixel(x, y)[channel]) > 3) {
          ++wrong;
          break;
        }
    }
  return wrong;
}

TEST_F(TexturedSquare, showsEverySquareOfACheckeredImageInItsPlaceAtEveryDistance) {
  wear({2048, 2048, checkered});
  for (const double texels_px : {0.3, 1.0, 2.5, 4.0, 9.0}) {
    const core::View view = above({kSide * 0.45, kSide * 0.55}, texels_px * kSide / 2048);
    drawReferences(view);
    int compared = 0;
    EXPECT_EQ(
        wrongPixels(
            drawSquare(view), view, kSide, 4 * texels_px + 2,
            [this](double c, uint32_t x, uint32_t y, int i) { return lit(c, x, y, i); }, pointAt, compared),
        0)
        << texels_px << " texels a pixel";
    EXPECT_GE(compared, texels_px < 8 ? 1000 : 0) << texels_px;
  }
}

TEST_F(TexturedSquare, keepsTheTilesOfTheCutThatIsDrawnUntilTheNextIsUploaded) {
  wear({512, 512, checkered});
  const core::View view = above({kSide / 2, kSide / 2}, kSide / 200);
  render::Renderer renderer;
  auto first = std::make_shared<core::Cut>(*cutOf({square(glm::u8vec4(255), AttributeSet::kTexture)}));
  first->textures = set_;
  first->tiles = tiles_;
  renderer.show(first);
  renderer.uploadInRenderThread({.wait = true});
  const render::Image before = draw(renderer, view);

  auto second = std::make_shared<core::Cut>(*cutOf({square(glm::u8vec4(255), AttributeSet::kTexture)}));
  second->textures = set_;
  renderer.show(second);
  renderer.uploadInRenderThread({.bytes = 0, .ms = 0});
  ASSERT_FALSE(renderer.upToDate());
  EXPECT_EQ(draw(renderer, view).rgba, before.rgba);
  renderer.uploadInRenderThread({.wait = true});
  EXPECT_EQ(renderer.textures().tileCount(), 0u);
}

TEST_F(TexturedSquare, looksSmoothFromAfar) {
  wear({1024, 1024, [](uint32_t x, uint32_t y) {
          const uint8_t value = (x / 8 + y / 8) % 2 == 0 ? 255 : 0;
          return glm::u8vec4(value, value, value, 255);
        }});
  for (const double texels_px : {17.0, 30.0, 100.0}) {
    const core::View view = above({kSide * 0.5, kSide * 0.5}, texels_px * kSide / 1024);
    drawReferences(view);
    const render::Image image = drawSquare(view);
    for (uint32_t y = 0; y < image.height_px; ++y)
      for (uint32_t x = 0; x < image.width_px; ++x) {
        const glm::dvec2 uv = pointAt(view, x, y) / kSide;
        const double margin = texels_px / 1024;
        if (glm::any(glm::lessThan(uv, glm::dvec2(margin))) ||
            glm::any(glm::greaterThan(uv, glm::dvec2(1 - margin))))
          continue;
        ASSERT_NEAR(image.pixel(x, y)[1], lit(0.5, x, y, 1), 12) << texels_px;
      }
  }
}

/// Expected light of a surface of this colour.
void expectPaint(const render::Image& image, const render::Image& painted, const std::string& what) {
  const uint8_t* const pixel = image.pixel(image.width_px / 2, image.height_px / 2);
  const uint8_t* const expected = painted.pixel(image.width_px / 2, image.height_px / 2);
  for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(pixel[channel], expected[channel], 3) << what;
}

TEST_F(TexturedSquare, showsTheNumberOfTexelsUnderAPixel) {
  const double steps_a_pixel[] = {2, 4, 8, 16, 32};
  for (size_t i = 0; i < std::size(steps_a_pixel); ++i) {
    const core::View view = above({2048, 2048}, steps_a_pixel[i]);
    wear(noise(512, 512));  // a texel is 8 steps wide
    shown_ = render::ColorMode::kTexels;
    const render::Image image = drawSquare(view);
    shown_ = render::ColorMode::kSurface;
    const glm::u8vec4 paint(render::texelColours()[i], 255);
    expectPaint(image, drawSquare(view, paint, AttributeSet::kColour), std::to_string(steps_a_pixel[i]));
  }
}

TEST_F(TexturedSquare, marksSurfacesWithoutAnImage) {
  const core::View view = above({2048, 2048}, 8);
  shown_ = render::ColorMode::kTexels;
  const render::Image image = drawSquare(view, glm::u8vec4(255), AttributeSet::kColour);
  shown_ = render::ColorMode::kSurface;
  const glm::u8vec4 paint(render::texelColours().back(), 255);
  expectPaint(image, drawSquare(view, paint, AttributeSet::kColour), "no image");
}

TEST_F(TexturedSquare, showsTheFinestResidentLevel) {
  wear({2048, 2048, checkered});
  std::erase_if(tiles_, [](const core::ResidentTile& tile) { return tile.key.level < 2; });
  const core::View view = above({kSide * 0.45, kSide * 0.55}, 0.3 * kSide / 2048);
  drawReferences(view);
  int compared = 0;
  EXPECT_EQ(
      wrongPixels(
          drawSquare(view), view, kSide, 8,
          [this](double c, uint32_t x, uint32_t y, int i) { return lit(c, x, y, i); }, pointAt, compared),
      0);
  EXPECT_GE(compared, 1000);
}

TEST_F(TexturedSquare, isDrawnPlainWithoutTilesOrImage) {
  wear({2048, 2048, checkered});
  const core::View view = above({kSide / 2, kSide / 2}, 1);
  tiles_.clear();
  const uint8_t attributes = AttributeSet::kTexture | AttributeSet::kColour;
  const glm::u8vec4 colour(40, 90, 160, 255);
  const render::Image plain = drawSquare(view, colour, AttributeSet::kColour);
  EXPECT_EQ(drawSquare(view, colour, attributes).rgba, plain.rgba);
  auto missing = std::make_shared<TextureSet>();
  missing->textures.push_back({"gone.png", 0, 0, {}});
  set_ = missing;
  EXPECT_EQ(drawSquare(view, colour, attributes).rgba, plain.rgba);
  set_ = std::make_shared<TextureSet>();
  EXPECT_EQ(drawSquare(view, colour, attributes).rgba, plain.rgba);
}

TEST_F(TexturedSquare, isTheImageTimesTheVertexColour) {
  wear({64, 64, [](uint32_t, uint32_t) { return glm::u8vec4(255, 0, 255, 255); }});
  const core::View view = above({kSide / 2, kSide / 2}, 1);
  const render::Image image =
      drawSquare(view, {200, 200, 0, 255}, AttributeSet::kTexture | AttributeSet::kColour);
  const render::Image expected = drawSquare(view, {200, 0, 0, 255}, AttributeSet::kColour);
  EXPECT_EQ(image.rgba, expected.rgba);
}

/// An image whose left half is transparent.
void expectRightHalf(const render::Image& image) {
  for (uint32_t y = 0; y < image.height_px; y += 10)
    for (uint32_t x = 0; x < image.width_px; ++x) {
      if (x < kWidthPx / 2 - 10) {
        EXPECT_TRUE(isMagenta(image.pixel(x, y)));
      }
      if (x > kWidthPx / 2 + 10) {
        EXPECT_FALSE(showsMagenta(image.pixel(x, y)));
      }
      EXPECT_EQ(image.pixel(x, y)[3], 255);
    }
}

TEST_F(TexturedSquare, leavesOutClearTexels) {
  wear({64, 64, [](uint32_t x, uint32_t) { return glm::u8vec4(255, 255, 255, x < 32 ? 0 : 255); }});
  const core::View view = above({kSide / 2, kSide / 2}, kSide / 500);
  const render::Image image = drawSquare(view);
  expectRightHalf(image);
  const render::Image one_sample = drawSquare(view, glm::u8vec4(255), AttributeSet::kTexture, 1);
  expectRightHalf(one_sample);
  for (uint32_t x = 0; x < one_sample.width_px; ++x) {
    const uint8_t* const pixel = one_sample.pixel(x, 70);
    EXPECT_EQ(showsMagenta(pixel), isMagenta(pixel)) << x << " is covered in part";
  }
}

/// A striped floor seen at a grazing angle: the stripes must stay distinct far ahead.
TEST_F(TexturedSquare, keepsStripesApartAtAFlatAngle) {
  wear({1024, 1024, [](uint32_t x, uint32_t) {
          const uint8_t value = x / 8 % 2 == 0 ? 255 : 0;
          return glm::u8vec4(value, value, value, 255);
        }});
  core::View view = lookAt({kSide / 2, -100, 100}, {kSide / 2, 1200, 0}, {0, 0, 1});
  const render::Image image = drawSquare(view);
  int least = 255, most = 0;
  for (uint32_t x = 60; x < 140; ++x) {
    const int value = image.pixel(x, kHeightPx / 2)[1];
    least = std::min(least, value);
    most = std::max(most, value);
  }
  EXPECT_GE(most - least, 100);
}

TEST_F(TexturedSquare, forgetsTilesThatALaterCutDoesNotHave) {
  wear({2048, 2048, checkered});
  render::Renderer renderer;
  auto cut = std::make_shared<core::Cut>(*cutOf({square(glm::u8vec4(255), AttributeSet::kTexture)}));
  cut->textures = set_;
  cut->tiles = tiles_;
  renderer.show(cut);
  renderer.uploadInRenderThread({.wait = true});
  EXPECT_EQ(renderer.textures().tileCount(), tiles_.size());
  auto fewer = std::make_shared<core::Cut>(*cut);
  fewer->tiles.resize(1);
  renderer.show(fewer);
  renderer.uploadInRenderThread({.wait = true});
  EXPECT_EQ(renderer.textures().tileCount(), 1u);
  renderer.show(cut);
  renderer.uploadInRenderThread({.wait = true});
  EXPECT_TRUE(renderer.upToDate());
  EXPECT_EQ(renderer.textures().tileCount(), tiles_.size());
}

TEST_F(TexturedSquare, uploadsNoMoreThanTheBudgetOfAFrameAllowsButOneTile) {
  wear({2048, 2048, checkered});
  render::TextureResidency residency(64u << 20);
  const std::shared_ptr<const core::Cut> cut = cutOfAllTiles();
  residency.show(cut);
  const uint64_t first = residency.uploadInRenderThread({.bytes = 1, .ms = 1e9});
  EXPECT_GE(first, tiles_.front().image->texels.size() * 4);  // the coarsest, and its tail
  EXPECT_LE(first, tiles_.front().image->texels.size() * 6);
  EXPECT_EQ(residency.tileCount(), 1u);
  EXPECT_LE(residency.uploadInRenderThread({.bytes = 2u << 20, .ms = 1e9}), 2u << 20);
  EXPECT_FALSE(residency.upToDate());
}

TEST_F(TexturedSquare, staysWithinItsMemoryAndShowsTheTilesThatFit) {
  wear({2048, 2048, checkered});
  render::TextureResidency residency(4 * uint64_t{render::kTileLayerBytes});
  const std::shared_ptr<const core::Cut> cut = cutOfAllTiles();
  residency.show(cut);
  residency.uploadInRenderThread({.wait = true});
  EXPECT_TRUE(residency.upToDate());
  EXPECT_EQ(residency.bytes(), 4 * uint64_t{render::kTileLayerBytes});
  EXPECT_GE(residency.tileCount(), 4u);
  EXPECT_LT(residency.tileCount(), tiles_.size());
}

TEST_F(TexturedSquare, hasMoreOrFewerTilesWithAnotherMemory) {
  wear({2048, 2048, checkered});
  render::TextureResidency residency(4 * uint64_t{render::kTileLayerBytes});
  const std::shared_ptr<const core::Cut> cut = cutOfAllTiles();
  const auto tilesWithin = [&](uint64_t layers) {
    residency.setBudget(layers * render::kTileLayerBytes);
    residency.show(cut);
    residency.uploadInRenderThread({.wait = true});
    EXPECT_TRUE(residency.upToDate());
    EXPECT_LE(residency.bytes(), layers * render::kTileLayerBytes);
    return residency.tileCount();
  };
  const size_t few = tilesWithin(4);
  EXPECT_EQ(tilesWithin(64), tiles_.size());
  EXPECT_EQ(tilesWithin(4), few);
  residency.setBudget(64 * render::kTileLayerBytes);
  EXPECT_EQ(residency.tileCount(), few) << "what is there stays where there may be more";
}

}  // namespace
}  // namespace lode::test
