#include "client/app/window/output/picture_request.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using std::chrono::milliseconds;

constexpr PictureRequest::TimePoint kStart{};

TEST(PictureRequest, isTakenOnceWhenTheWindowIsAtRest) {
  PictureRequest request;
  EXPECT_FALSE(request.take(true, kStart)) << "before anyone asks";
  request.ask(kStart);
  EXPECT_FALSE(request.take(false, kStart + milliseconds(100)));
  EXPECT_TRUE(request.take(true, kStart + milliseconds(200)));
  EXPECT_FALSE(request.take(true, kStart + milliseconds(300)));
}

TEST(PictureRequest, isTakenAfterTwoSecondsWhateverMoves) {
  PictureRequest request;
  request.ask(kStart);
  EXPECT_FALSE(request.take(false, kStart + milliseconds(1999)));
  EXPECT_TRUE(request.take(false, kStart + milliseconds(2000)));
}

TEST(PictureRequest, waitsNoLongerWhereTheKeyIsHeld) {
  PictureRequest request;
  request.ask(kStart);
  request.ask(kStart + milliseconds(1500));
  EXPECT_TRUE(request.take(false, kStart + milliseconds(2000)));
}

}  // namespace
}  // namespace lode::app
