#include "client/app/window/panel/first_start.h"

#include <gtest/gtest.h>

#include "tests/support/work_folder.h"

namespace lode::app {
namespace {

TEST(FirstStart, showsTheHelpUntilItWasSeen) {
  const test::WorkFolder work;
  const FirstStart first(work.path() / "cache" / "lodestream");
  EXPECT_TRUE(first.isHelpDue());
  EXPECT_TRUE(first.isHelpDue());
  first.helpWasSeen();
  EXPECT_FALSE(first.isHelpDue());
  EXPECT_FALSE(FirstStart(work.path() / "cache" / "lodestream").isHelpDue());
}

TEST(FirstStart, toleratesAnUnwritableFolder) {
  const FirstStart first("/proc/lodestream");
  first.helpWasSeen();
  EXPECT_TRUE(first.isHelpDue());
}

}  // namespace
}  // namespace lode::app
