#include "client/render/cross_fade.h"

#include <map>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "gl_fixture.h"
#include "tests/support/test_meshes.h"

namespace lode::test {
namespace {

using core::Cut;
using render::CrossFade;
using render::DrawItem;
using render::FadedItem;
using render::kFadeS;

const core::View kAhead = lookAt({500, 500, 3000}, {500, 500, 0});
const core::View kAway = lookAt({500, 500, 3000}, {500, 500, 6000});
const NodeKey kNode = kRootKey.child(3);
const std::vector kChildren{kNode.child(0), kNode.child(2), kNode.child(5)};

/// Frames of covers without anything on a GPU.
struct Frames {
  CrossFade fade;
  uint64_t serial = 0;
  std::map<NodeKey, std::shared_ptr<const Mesh>> meshes;
  std::vector<DrawItem> drawn;
  std::shared_ptr<Cut> cut;

  void take(const std::vector<NodeKey>& nodes, float error_model = 0,
            std::vector<core::LeftOut> left_out = {}) {
    cut = std::make_shared<Cut>();
    drawn.clear();
    for (const NodeKey node : nodes) {
      std::shared_ptr<const Mesh>& mesh = meshes[node];
      if (!mesh) mesh = std::make_shared<const Mesh>();
      cut->parts.push_back({node, 0, true, 0, mesh});
      DrawItem item;
      item.index_count = 3;
      item.box.add({400, 400, 0});
      item.box.add({600, 600, 0});
      item.node = node;
      item.error_model = error_model;
      drawn.push_back(item);
    }
    cut->left_out = std::move(left_out);
    ++serial;
  }
  void draw(double now_s, const core::View& view = kAhead) {
    std::vector<uint32_t> numbers(drawn.size());
    std::iota(numbers.begin(), numbers.end(), 0u);
    fade.show({cut, drawn, numbers, serial}, view, 1, {now_s, true});
  }
  void show(double now_s, const std::vector<NodeKey>& nodes, float error_model = 0) {
    take(nodes, error_model);
    draw(now_s);
  }

  /// That a node's place is covered with, at a dither value.
  int surfacesAt(NodeKey place, float value) const {
    return static_cast<int>(std::ranges::count_if(fade.items(), [&](const FadedItem& faded) {
      return faded.item.node.contains(place) && value >= faded.from && value < faded.to;
    }));
  }
  float shareOf(NodeKey node) const {
    for (const FadedItem& faded : fade.items())
      if (faded.item.node == node) return faded.to - faded.from;
    return 0;
  }
};

TEST(CrossFade, letsChildrenTakeTheirParentsPixelsInAQuarterOfASecond) {
  Frames frames;
  frames.show(1, {kNode});
  EXPECT_FALSE(frames.fade.fading());
  frames.show(2, kChildren);
  EXPECT_TRUE(frames.fade.fading());
  EXPECT_EQ(frames.shareOf(kNode), 1);
  frames.draw(2 + kFadeS / 4);
  EXPECT_FLOAT_EQ(frames.shareOf(kNode), 0.75f);
  for (const NodeKey child : kChildren) EXPECT_FLOAT_EQ(frames.shareOf(child), 0.25f);
  frames.draw(2 + kFadeS);
  EXPECT_FALSE(frames.fade.fading());
  EXPECT_EQ(frames.fade.items().size(), 3u);
  EXPECT_TRUE(std::ranges::all_of(frames.fade.items(), &FadedItem::whole));
}

TEST(CrossFade, isOfEachRegionByItsOwnClock) {
  const NodeKey other = kRootKey.child(6);
  Frames frames;
  frames.show(0, {kNode, other});
  frames.show(1, {kNode.child(1), other});
  frames.show(1 + kFadeS / 2, {kNode.child(1), other.child(1)});
  frames.draw(1 + kFadeS * 3 / 4);
  EXPECT_FLOAT_EQ(frames.shareOf(kNode.child(1)), 0.75f);
  EXPECT_FLOAT_EQ(frames.shareOf(other.child(1)), 0.25f);
}

/// Splits and joins nodes of a cover at random.
std::vector<NodeKey> changed(const std::vector<NodeKey>& before, std::mt19937& random) {
  std::vector<NodeKey> after;
  for (const NodeKey node : before) {
    if (std::ranges::any_of(after, [&](NodeKey other) { return other.contains(node); })) continue;
    if (node.depth() < 4 && random() % 8 == 0) {
      for (unsigned octant = 0; octant < 8; ++octant) after.push_back(node.child(octant));
    } else if (node.depth() > 1 && random() % 12 == 0) {
      std::erase_if(after, [&](NodeKey other) { return node.parent().contains(other); });
      after.push_back(node.parent());
    } else {
      after.push_back(node);
    }
  }
  return after;
}

TEST(CrossFade, showsOneSurfaceAtEachPixelHoweverChangesFollowOneAnother) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> value(0, 1);
  for (int round = 0; round < 20; ++round) {
    Frames frames;
    std::vector<NodeKey> nodes;
    for (unsigned octant = 0; octant < 8; ++octant) nodes.push_back(kRootKey.child(octant));
    int fading = 0;
    double now_s = 0;
    for (int frame = 0; frame < 100; ++frame, now_s += 0.03) {
      if (frame % 3 == 0) {
        nodes = changed(nodes, random);
        // Some steps are too large to fade: they end the fades around them.
        frames.take(nodes);
        for (DrawItem& item : frames.drawn) item.error_model = random() % 20 == 0 ? 1000.0f : 0.0f;
      }
      frames.draw(now_s);
      fading += frames.fade.fading();
      for (int place = 0; place < 40; ++place) {
        const NodeKey leaf{(uint64_t{1} << 15) | (random() & 0x7fff)};
        ASSERT_EQ(frames.surfacesAt(leaf, value(random)), 1) << "frame " << frame;
      }
    }
    EXPECT_GT(fading, 40);
  }
}

TEST(CrossFade, switchesAtOnceWhereTheStepIsLarge) {
  Frames frames;
  frames.show(1, {kNode}, 1000);
  frames.show(2, kChildren);
  EXPECT_FALSE(frames.fade.fading());
  EXPECT_EQ(frames.fade.items().size(), 3u);
}

TEST(CrossFade, isBetweenRungsOfANode) {
  Frames frames;
  frames.show(1, {kNode});
  frames.meshes.clear();
  frames.show(2, {kNode});
  EXPECT_TRUE(frames.fade.fading());
}

TEST(CrossFade, switchesAtOnceToAnotherBuildOfTheModel) {
  Frames frames;
  frames.show(1, {kNode});
  frames.show(2, kChildren);
  frames.take({kNode});
  frames.cut->build = 7;
  frames.draw(2.1);
  EXPECT_FALSE(frames.fade.fading());
  EXPECT_EQ(frames.shareOf(kNode), 1);
}

TEST(CrossFade, switchesAtOnceWhereTheCameraSeesWhatOneSideLeavesOut) {
  const core::LeftOut ahead{kNode.child(7), {{450, 450, -10}, {550, 550, 10}}};
  Frames frames;
  frames.take(kChildren, 0, {ahead});
  frames.draw(1, kAway);
  frames.take({kNode});
  frames.draw(2, kAway);
  EXPECT_TRUE(frames.fade.fading());
  frames.draw(2.01, kAhead);
  EXPECT_FALSE(frames.fade.fading());
  EXPECT_EQ(frames.shareOf(kNode), 1);

  frames.take(kChildren, 0, {ahead});
  frames.draw(3, kAhead);
  EXPECT_FALSE(frames.fade.fading());
}

TEST(CrossFade, doesNotHeedWhatWasLeftOutBeforeAnEarlierFade) {
  const core::LeftOut ahead{kNode.child(7), {{450, 450, -10}, {550, 550, 10}}};
  const NodeKey other = kRootKey.child(6);
  Frames frames;
  frames.take({kNode.child(0), other}, 0, {ahead});
  frames.draw(1, kAway);
  frames.take({kNode, other});
  frames.draw(2, kAway);
  frames.take({kNode, other.child(0)});  // so that something fades all the time
  frames.draw(2 + kFadeS / 2, kAway);
  frames.take({kNode.child(0), kNode.child(7), other.child(0)});
  frames.draw(2 + kFadeS, kAway);
  frames.draw(2 + kFadeS * 5 / 4, kAhead);
  EXPECT_FLOAT_EQ(frames.shareOf(kNode), 0.75f);
}

TEST(CrossFade, endsAboveAndAroundAPlaceThatIsLeftOutToo) {
  Frames frames;
  frames.take(kChildren, 0, {{kNode.child(7), {{450, 450, -10}, {550, 550, 10}}}});
  frames.draw(1, kAway);
  frames.take({kNode, kRootKey.child(6)});
  frames.draw(2, kAway);
  frames.take({kRootKey});
  frames.draw(2 + kFadeS / 2, kAway);
  frames.draw(2 + kFadeS * 3 / 4, kAhead);
  EXPECT_FALSE(frames.fade.fading());
  EXPECT_EQ(frames.shareOf(kRootKey), 1);
}

TEST(CrossFade, isWhereAFallbackCoversWhatIsLeftOut) {
  Frames frames;
  frames.take({kNode.child(0), kNode.child(7)}, 0,
              {{kNode.child(7).child(1), {{450, 450, -10}, {550, 550, 10}}}});
  frames.draw(1);
  frames.show(2, {kNode});
  EXPECT_TRUE(frames.fade.fading());
}

TEST(CrossFade, tellsHowLongEachPartIsInThePictureWhetherItFadesOrNot) {
  const NodeKey other = kRootKey.child(6);
  Frames frames;
  frames.show(1, {kNode, other});
  frames.show(3, {kNode.child(1), other});
  frames.draw(5);
  const auto ageOf = [&](NodeKey node) {
    for (const FadedItem& faded : frames.fade.items())
      if (faded.item.node == node) return faded.item.age_s;
    return -1.0f;
  };
  EXPECT_EQ(ageOf(other), 4);
  EXPECT_EQ(ageOf(kNode.child(1)), 2);
  frames.fade.forget();
  frames.draw(6);
  EXPECT_EQ(ageOf(other), 5);
}

TEST(CrossFade, tellsWhichCutsMeshesAreStillDrawn) {
  Frames frames;
  frames.show(1, {kNode});
  const uint64_t first = frames.serial;
  frames.show(2, kChildren);
  frames.show(2 + kFadeS / 2, {kNode});
  EXPECT_EQ(frames.fade.oldestSerial(), first);
  frames.draw(2 + kFadeS);
  EXPECT_EQ(frames.fade.oldestSerial(), first + 1);
}

using FadedPicture = GlTest;

/// Shows squares of some colours one after another, in the same place, and what they cover a moment later.
struct Shares {
  int red = 0, green = 0, blue = 0, background = 0, mixed = 0;
};

Shares sharesOf(const render::Image& image) {
  Shares shares;
  for (uint32_t y = 0; y < image.height_px; ++y) {
    for (uint32_t x = 0; x < image.width_px; ++x) {
      const uint8_t* const p = image.pixel(x, y);
      if (isMagenta(p)) {
        ++shares.background;
      } else if (p[0] > 2 * (p[1] + p[2])) {
        ++shares.red;
      } else if (p[1] > 2 * (p[0] + p[2])) {
        ++shares.green;
      } else if (p[2] > 2 * (p[0] + p[1])) {
        ++shares.blue;
      } else {
        ++shares.mixed;
      }
    }
  }
  return shares;
}

class Squares {
 public:
  Squares() : target_(kWidthPx, kHeightPx) {}
  void show(glm::u8vec4 colour, double now_s, uint32_t z = 500) {
    auto cut = std::make_shared<Cut>();
    cut->parts.push_back(
        {kRootKey, 0, true, 0, std::make_shared<const Mesh>(squareAt(0, 0, z, 1000, colour))});
    alive_.push_back(cut);
    renderer.show(cut);
    renderer.uploadInRenderThread({.wait = true});
    sharesAt(now_s);
  }
  Shares sharesAt(double now_s, bool fades = true) {
    renderer.draw(lookAt({500, 500, 800}, {500, 500, 0}), target_, GlTest::magentaBehind(), {now_s, fades});
    target_.resolve();
    return sharesOf(target_.readPixels());
  }
  render::Renderer renderer{1, {.budget_bytes = 1u << 20, .spare_bytes = 0, .page_bytes = 4096}};

 private:
  std::vector<std::shared_ptr<Cut>> alive_;
  render::Framebuffer target_;
};

constexpr glm::u8vec4 kRed(255, 0, 0, 255), kGreen(0, 255, 0, 255), kBlue(0, 0, 255, 255);
constexpr int kPixels = kWidthPx * kHeightPx;

TEST_F(FadedPicture, showsOneOfTheSurfacesAtEachPixelAndNeverTheBackground) {
  Squares squares;
  squares.show(kRed, 0);
  squares.show(kGreen, 1, 400);  // behind, so that depth would not choose it
  for (const double part : {0.1, 0.37, 0.5, 0.9}) {
    const Shares shares = squares.sharesAt(1 + part * kFadeS);
    EXPECT_EQ(shares.background + shares.mixed, 0) << part;
    EXPECT_NEAR(shares.green, part * kPixels, 0.03 * kPixels) << part;
    EXPECT_EQ(shares.red + shares.green, kPixels);
  }
  EXPECT_EQ(squares.sharesAt(1 + kFadeS).green, kPixels);
}

TEST_F(FadedPicture, doesNotLetDepthChooseBetweenTheSurfaces) {
  Squares behind, before;
  behind.show(kRed, 0);
  behind.show(kGreen, 1, 400);
  before.show(kRed, 0);
  before.show(kGreen, 1, 600);
  for (const double part : {0.1, 0.37, 0.5, 0.9})
    EXPECT_EQ(behind.sharesAt(1 + part * kFadeS).green, before.sharesAt(1 + part * kFadeS).green);
}

TEST_F(FadedPicture, showsThreeSurfacesInTurnWithoutTheBackground) {
  Squares squares;
  squares.show(kRed, 0);
  squares.show(kGreen, 1, 400);
  squares.show(kBlue, 1 + kFadeS / 2, 300);
  const Shares shares = squares.sharesAt(1 + kFadeS * 3 / 4);
  EXPECT_EQ(shares.red + shares.green + shares.blue, kPixels);
  EXPECT_NEAR(shares.blue, kPixels / 4, 0.03 * kPixels);
  EXPECT_NEAR(shares.green, kPixels / 2, 0.03 * kPixels);
}

TEST_F(FadedPicture, isDrawnAtOnceWhereNothingIsToFade) {
  Squares squares;
  squares.show(kRed, 0);
  squares.show(kGreen, 1);
  EXPECT_TRUE(squares.renderer.fading());
  EXPECT_EQ(squares.sharesAt(1.1, false).green, kPixels);
  EXPECT_FALSE(squares.renderer.fading());
}

TEST_F(FadedPicture, keepsWhatLeavesOnTheGpuUntilItIsGone) {
  Squares squares;
  squares.show(kRed, 0);
  squares.show(kGreen, 1);
  EXPECT_EQ(squares.renderer.meshes().meshCount(), 2u);
  squares.sharesAt(1 + kFadeS);
  squares.renderer.uploadInRenderThread({});
  EXPECT_EQ(squares.renderer.meshes().meshCount(), 1u);
}

/// A square at two places, of which the other one's stays.
TEST_F(FadedPicture, fadesAtOnePlaceOfAModelAndStaysAtAnother) {
  const auto cutOfSquare = [](glm::u8vec4 colour) {
    auto cut = std::make_shared<Cut>();
    cut->parts.push_back(
        {kRootKey, 0, true, 0, std::make_shared<const Mesh>(squareAt(0, 0, 500, 1000, colour))});
    return cut;
  };
  const auto red = cutOfSquare(kRed), green = cutOfSquare(kGreen);
  render::Renderer renderer(1);
  const render::Framebuffer target(kWidthPx, kHeightPx);
  const auto sharesAt = [&](size_t place, double now_s) {
    renderer.drawPlace(place, lookAt({500, 500, 800}, {500, 500, 0}), target, GlTest::magentaBehind(),
                       {now_s, true});
    target.resolve();
    return sharesOf(target.readPixels());
  };
  const auto show = [&](std::vector<std::shared_ptr<const Cut>> cuts) {
    renderer.show(std::make_shared<const core::PlacedCuts>(core::PlacedCuts{cuts, core::gatherMeshes(cuts)}));
    renderer.uploadInRenderThread({.wait = true});
  };
  show({red, red});
  for (const size_t place : {0u, 1u}) sharesAt(place, 0);
  show({red, green});
  for (const size_t place : {0u, 1u}) sharesAt(place, 1);
  EXPECT_EQ(sharesAt(0, 1 + kFadeS / 2).red, kPixels);
  EXPECT_NEAR(sharesAt(1, 1 + kFadeS / 2).green, kPixels / 2, 0.03 * kPixels);
  EXPECT_TRUE(renderer.fading());
  renderer.leaveOut(1);
  EXPECT_FALSE(renderer.fading());
  EXPECT_EQ(sharesAt(1, 1 + kFadeS / 2).green, kPixels) << "it comes into sight again";
}

/// A budget for two grids and no third.
TEST_F(FadedPicture, isGivenUpWhereThereIsNoRoomForWhatLeaves) {
  const auto cutOfGrid = [](uint32_t seed) {
    auto cut = std::make_shared<Cut>();
    cut->parts.push_back({kRootKey, 0, true, 0,
                          std::make_shared<const Mesh>(makeGrid(32, 32, {.attributes = {}, .seed = seed}))});
    return cut;
  };
  const uint32_t grid_bytes = 33 * 33 * 16 + 2 * 32 * 32 * 12;
  render::Renderer renderer(1, {.budget_bytes = 2 * grid_bytes, .page_bytes = 2 * grid_bytes});
  const render::Framebuffer target(kWidthPx, kHeightPx);
  const core::View view = lookAt({2048, 2048, 9000}, {2048, 2048, 0});
  const auto cuts = {cutOfGrid(1), cutOfGrid(2), cutOfGrid(3)};
  double now_s = 0;
  for (const auto& cut : cuts) {
    renderer.show(cut);
    renderer.uploadInRenderThread({.wait = true});
    EXPECT_TRUE(renderer.upToDate());
    renderer.draw(view, target, magentaBehind(), {now_s += 0.05, true});
    EXPECT_LE(renderer.meshes().pages().capacityBytes(), 2 * grid_bytes);
  }
  // The first had to go for the third, while it faded into the second.
  renderer.draw(view, target, magentaBehind(), {now_s + 0.05, true});
  EXPECT_FALSE(renderer.fading());
}

}  // namespace
}  // namespace lode::test
