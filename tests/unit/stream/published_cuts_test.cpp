#include "client/stream/published_cuts.h"

#include <gtest/gtest.h>

namespace lode::stream {
namespace {

TEST(PublishedCuts, areFreedOnReleaseNotByTheirLastUser) {
  PublishedCuts published;
  auto cut = std::make_shared<const core::Cut>();
  const std::weak_ptr<const core::Cut> seen = cut;
  published.add(cut, nullptr);
  cut.reset();
  EXPECT_FALSE(seen.expired());
  published.releaseStorage();
  EXPECT_TRUE(seen.expired());
}

TEST(PublishedCuts, stayWhileInUseHoweverManyFollow) {
  PublishedCuts published;
  auto cut = std::make_shared<const core::Cut>();
  const std::weak_ptr<const core::Cut> seen = cut;
  published.add(cut, nullptr);
  for (int i = 0; i < 3; ++i) {
    published.add(std::make_shared<const core::Cut>(), nullptr);
    published.releaseStorage();
  }
  cut.reset();
  EXPECT_FALSE(seen.expired());
  published.releaseStorage();
  EXPECT_TRUE(seen.expired());
}

TEST(PublishedCuts, areFreedWithTheCutsOfTheirViews) {
  PublishedCuts published;
  core::ViewCuts places;
  places.all = std::make_shared<const core::Cut>();
  const std::weak_ptr<const core::Cut> seen = places.all;
  auto view_cuts = std::make_shared<const core::ViewCuts>(std::move(places));
  published.add(view_cuts->all, view_cuts);
  published.add(view_cuts->all, view_cuts);
  published.releaseStorage();
  view_cuts.reset();
  EXPECT_FALSE(seen.expired());
  published.releaseStorage();
  EXPECT_TRUE(seen.expired());
}

}  // namespace
}  // namespace lode::stream
