#include "client/app/window/sharpness.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(Sharpness, isToldAsTheMostThatAPictureMayBeOff) {
  EXPECT_EQ(convergedText(0.834f, 1), "converged, at most 0.83 px off where it is seen");
  EXPECT_EQ(refiningText(12), "refining, at most 12.00 px off where it is seen");
}

TEST(Sharpness, isTheFilesOwnWhereThereIsNothingFiner) {
  for (const float error_px : {1.5f, 746.0f}) {
    const std::string text = convergedText(error_px, 1);
    EXPECT_NE(text.find("the file's own"), std::string::npos);
    EXPECT_EQ(text.find("px"), std::string::npos) << "a bound that says nothing";
  }
}

TEST(Sharpness, isNotToldByABoundThatSaysNothing) { EXPECT_EQ(refiningText(746), "refining"); }

TEST(Sharpness, isABoundWithoutAPromiseWhereMemoryAllowsNoMore) {
  EXPECT_EQ(limitedText(0.4f), "at most 0.40 px off where it is seen");
  EXPECT_EQ(limitedText(1e9f), "coarse where it is nearest");
}

}  // namespace
}  // namespace lode::app
