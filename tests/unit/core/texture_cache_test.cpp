#include "client/core/textures/texture_cache.h"

#include <vector>

#include <gtest/gtest.h>

#include "client/core/textures/texture_wants.h"

namespace lode::core {
namespace {

std::shared_ptr<const TileImage> imageOf(uint32_t edge) {
  return std::make_shared<const TileImage>(
      TileImage{glm::uvec2(edge), std::vector<glm::u8vec4>(edge * edge), {}});
}

const uint64_t kRoom = tileRoomBytes(glm::uvec2(64));

TEST(TextureCache, countsTheRoomOfItsTiles) {
  TextureCache cache(1u << 30);
  cache.insert(1, imageOf(60));
  cache.insert(2, imageOf(64));
  cache.insert(2, imageOf(64));
  EXPECT_EQ(cache.bytes(), 2 * kRoom);
  EXPECT_EQ(cache.size(), 2u);
}

TEST(TextureCache, evictsTheLeastRecentlyUsedFirst) {
  TextureCache cache(2 * kRoom);
  cache.insert(1, imageOf(64));
  cache.use(std::vector<uint32_t>{1});
  cache.insert(2, imageOf(64));
  cache.use(std::vector<uint32_t>{2});
  cache.insert(3, imageOf(64));
  cache.use(std::vector<uint32_t>{3});
  EXPECT_FALSE(cache.find(1));
  EXPECT_TRUE(cache.find(2));
  EXPECT_TRUE(cache.find(3));
  EXPECT_LE(cache.bytes(), cache.budgetBytes());
}

TEST(TextureCache, keepsTilesInUseBeyondTheBudget) {
  TextureCache cache(kRoom);
  cache.insert(1, imageOf(64));
  cache.insert(2, imageOf(64));
  cache.use(std::vector<uint32_t>{1, 2});
  EXPECT_EQ(cache.size(), 2u);
  cache.use(std::vector<uint32_t>{1});
  EXPECT_TRUE(cache.find(1));
  EXPECT_FALSE(cache.find(2));
}

}  // namespace
}  // namespace lode::core
