#include "client/app/window/output/picture_file.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

TEST(PictureFile, mayBeWhatStandardOutputGoesTo) {
  testing::internal::CaptureStdout();  // into a file without an ending
  EXPECT_NO_THROW(checkPictureFile("a.lode", "/dev/stdout"));
  testing::internal::GetCapturedStdout();
}

TEST(PictureFile, isCalledAPngUnlessItIsADevice) {
  const test::WorkFolder folder;
  EXPECT_NO_THROW(checkPictureFile("a.lode", folder / "a.png"));
  EXPECT_NO_THROW(checkPictureFile("a.lode", "/dev/null"));
  EXPECT_THROW(checkPictureFile("a.lode", folder / "a.jpg"), Error);
}

}  // namespace
}  // namespace lode::app
