#include "client/app/window/panel/start_page.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

TEST(StartPage, readsATypedTarget) {
  EXPECT_EQ(typedTarget(" a b.ply \n", "/home/u"), "a b.ply");
  EXPECT_EQ(typedTarget("~/a.ply", "/home/u"), "/home/u/a.ply");
  EXPECT_EQ(typedTarget("~", "/home/u"), "/home/u");
  EXPECT_EQ(typedTarget("~x/a.ply", "/home/u"), "~x/a.ply");
  EXPECT_EQ(typedTarget("~/a.ply", ""), "~/a.ply");
  EXPECT_EQ(typedTarget("  ", "/home/u"), "");
}

}  // namespace
}  // namespace lode::app
