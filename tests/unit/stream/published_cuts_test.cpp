#include "client/stream/published_cuts.h"

#include <gtest/gtest.h>

namespace lode::stream {
namespace {

TEST(PublishedCuts, areFreedWhenTheyAreLetGoAndNotWhereTheLastIsDropped) {
  PublishedCuts published;
  auto cut = std::make_shared<const core::Cut>();
  const std::weak_ptr<const core::Cut> seen = cut;
  published.add(cut, nullptr);
  cut.reset();
  EXPECT_FALSE(seen.expired());
  published.letGo();
  EXPECT_TRUE(seen.expired());
}

TEST(PublishedCuts, stayWhileSomebodyHasThemHoweverManyFollow) {
  PublishedCuts published;
  auto cut = std::make_shared<const core::Cut>();
  const std::weak_ptr<const core::Cut> seen = cut;
  published.add(cut, nullptr);
  for (int i = 0; i < 3; ++i) {
    published.add(std::make_shared<const core::Cut>(), nullptr);
    published.letGo();
  }
  cut.reset();
  EXPECT_FALSE(seen.expired());
  published.letGo();
  EXPECT_TRUE(seen.expired());
}

TEST(PublishedCuts, goWithThePlacesThatTheyAreShownAt) {
  PublishedCuts published;
  core::PlacedCuts places;
  places.all = std::make_shared<const core::Cut>();
  const std::weak_ptr<const core::Cut> seen = places.all;
  auto placed = std::make_shared<const core::PlacedCuts>(std::move(places));
  published.add(placed->all, placed);
  published.add(placed->all, placed);
  published.letGo();
  placed.reset();
  EXPECT_FALSE(seen.expired());
  published.letGo();
  EXPECT_TRUE(seen.expired());
}

}  // namespace
}  // namespace lode::stream
