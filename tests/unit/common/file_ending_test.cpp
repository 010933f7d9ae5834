#include "common/io/file_ending.h"

#include <gtest/gtest.h>

namespace lode {
namespace {

TEST(FileEnding, isTheLastInSmallLetters) { EXPECT_EQ(fileEnding("/a.b/model.LODE.Png"), ".png"); }

TEST(FileEnding, isEmptyOfANameWithoutOne) { EXPECT_EQ(fileEnding("/a.b/model"), ""); }

}  // namespace
}  // namespace lode
