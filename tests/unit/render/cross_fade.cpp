#include "client/render/passes/cross_fade.h"

#include <map>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "gl_fixture.h"

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

/// Frames of covers without a GPU.
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

  /// Returns the number of parts that cover a node at a dither value.
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

TEST(CrossFade, replacesAParentByItsChildrenInAQuarterOfASecond) {
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

TEST(CrossFade, timesEachRegionSeparately) {
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
        // Some errors are too large to fade: they end the fades around them.
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

TEST(CrossFade, switchesAtOnceIfTheStepIsLarge) {
  Frames frames;
  frames.show(1, {kNode}, 1000);
  frames.show(2, kChildren);
  EXPECT_FALSE(frames.fade.fading());
  EXPECT_EQ(frames.fade.items().size(), 3u);
}

TEST(CrossFade, fadesBetweenLodsOfANode) {
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

TEST(CrossFade, switchesAtOnceIfTheCameraSeesALeftOutNode) {
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

TEST(CrossFade, ignoresNodesLeftOutBeforeAnEarlierFade) {
  const core::LeftOut ahead{kNode.child(7), {{450, 450, -10}, {550, 550, 10}}};
  const NodeKey other = kRootKey.child(6);
  Frames frames;
  frames.take({kNode.child(0), other}, 0, {ahead});
  frames.draw(1, kAway);
  frames.take({kNode, other});
  frames.draw(2, kAway);
  frames.take({kNode, other.child(0)});  // keeps another fade running
  frames.draw(2 + kFadeS / 2, kAway);
  frames.take({kNode.child(0), kNode.child(7), other.child(0)});
  frames.draw(2 + kFadeS, kAway);
  frames.draw(2 + kFadeS * 5 / 4, kAhead);
  EXPECT_FLOAT_EQ(frames.shareOf(kNode), 0.75f);
}

TEST(CrossFade, endsInRegionsAboveALeftOutNode) {
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

TEST(CrossFade, fadesWhereAFallbackCoversALeftOutNode) {
  Frames frames;
  frames.take({kNode.child(0), kNode.child(7)}, 0,
              {{kNode.child(7).child(1), {{450, 450, -10}, {550, 550, 10}}}});
  frames.draw(1);
  frames.show(2, {kNode});
  EXPECT_TRUE(frames.fade.fading());
}

TEST(CrossFade, givesTheAgeOfEachPartDuringAndAfterAFade) {
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

TEST(CrossFade, givesTheOldestCutThatIsStillDrawn) {
  Frames frames;
  frames.show(1, {kNode});
  const uint64_t first = frames.serial;
  frames.show(2, kChildren);
  frames.show(2 + kFadeS / 2, {kNode});
  EXPECT_EQ(frames.fade.oldestSerial(), first);
  frames.draw(2 + kFadeS);
  EXPECT_EQ(frames.fade.oldestSerial(), first + 1);
}

}  // namespace
}  // namespace lode::test
