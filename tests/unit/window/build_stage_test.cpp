#include "client/app/window/panel/build_stage.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(BuildStage, hasItsPlaceAmongThem) {
  EXPECT_EQ(describeStage("scan"), "scan, 1 of 6");
  EXPECT_EQ(describeStage("border"), "border, 4 of 6");
  EXPECT_EQ(describeStage("pack"), "pack, 6 of 6");
}

TEST(BuildStage, isNamedAloneWhereItIsNotKnown) { EXPECT_EQ(describeStage("polish"), "polish"); }

}  // namespace
}  // namespace lode::app
