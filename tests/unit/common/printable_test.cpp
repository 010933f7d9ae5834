#include "common/printable.h"

#include <gtest/gtest.h>

namespace lode {
namespace {

TEST(PrintableUtf8, refusesControlAndBidiCharactersAndInvalidSequences) {
  EXPECT_TRUE(isPrintableUtf8(""));
  EXPECT_TRUE(isPrintableUtf8("bunny (1) — größer 🐇"));
  EXPECT_FALSE(isPrintableUtf8("tab\t"));
  EXPECT_FALSE(isPrintableUtf8(std::string_view("nul\0", 4)));
  EXPECT_FALSE(isPrintableUtf8("del\x7F"));
  EXPECT_FALSE(isPrintableUtf8("c1 \xC2\x9B"));
  EXPECT_FALSE(isPrintableUtf8("turned \u202E"));
  EXPECT_FALSE(isPrintableUtf8("isolated \u2066"));
  EXPECT_FALSE(isPrintableUtf8("cut \xC3"));
  EXPECT_FALSE(isPrintableUtf8("overlong \xC0\xAF"));
  EXPECT_FALSE(isPrintableUtf8("overlong \xE0\x80\xAF"));
  EXPECT_FALSE(isPrintableUtf8("surrogate \xED\xA0\x80"));
  EXPECT_FALSE(isPrintableUtf8("beyond \xF4\x90\x80\x80"));
}

}  // namespace
}  // namespace lode
