#include "client/app/window/panel/sharpness.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(Sharpness, isGivenAsTheLargestPossibleError) {
  EXPECT_EQ(convergedText(0.834f, 1), "converged, at most 0.83 px off where it is seen");
  EXPECT_EQ(refiningText({12, 1, 5, 0}), "refining, at most 12.00 px off where it is seen");
}

TEST(Sharpness, isCalledTheFilesOwnAtTheFinestCut) {
  for (const float error_px : {1.5f, 746.0f}) {
    const std::string text = convergedText(error_px, 1);
    EXPECT_NE(text.find("the file's own"), std::string::npos);
    EXPECT_EQ(text.find("px"), std::string::npos) << "a bound that says nothing";
  }
}

TEST(Sharpness, isGivenByProgressIfTheErrorBoundIsMeaningless) {
  EXPECT_EQ(refiningText({746, 1, 0, 240'000}), "refining: 240.0 KB received");
}

TEST(Sharpness, namesMissingTilesOnceTheSurfaceIsComplete) {
  EXPECT_EQ(refiningText({0.05f, 1, 3, 0}), "textures: 3 tiles missing");
  EXPECT_EQ(refiningText({0.05f, 1, 1, 0}), "textures: 1 tile missing");
  EXPECT_EQ(refiningText({0.05f, 1, 0, 0}), "at most 0.05 px off where it is seen; the rest is loading");
}

TEST(Sharpness, promisesNothingIfMemoryIsExhausted) {
  EXPECT_EQ(limitedText(0.4f), "at most 0.40 px off where it is seen");
  EXPECT_EQ(limitedText(1e9f), "coarse where it is nearest");
}

TEST(Sharpness, explainsUnavailablePartsAndWaitsForTheServer) {
  EXPECT_EQ(lackingText(0.4f), "at most 0.40 px off where it is seen; finer parts are not available");
  EXPECT_EQ(waitingText(1e9f), "coarse where it is nearest; the rest waits for the server");
}

}  // namespace
}  // namespace lode::app
