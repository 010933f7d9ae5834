// Words of the C API for the remedies of errors.

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "client/embed/internal.h"

namespace lode::embed {
namespace {

TEST(Remedies, haveWordsThatDiffer) {
  EXPECT_STREQ(wordsFor(Remedy::kNone), "");
  std::set<std::string> all;
  for (int code = 1; code <= static_cast<int>(kLastRemedy); ++code) {
    const std::string words = wordsFor(static_cast<Remedy>(code));
    EXPECT_NE(words, "") << code;
    EXPECT_TRUE(all.insert(words).second) << words;
  }
}

TEST(Remedies, endTheLastError) {
  EXPECT_EQ(guard([] { throw Error(ErrorCode::kInput, "it is closed; try again"); }), 0);
  EXPECT_STREQ(lodestream_last_error(), "it is closed; try again");
  EXPECT_EQ(guard([] { throw Error(ErrorCode::kInput, "it requires a token", Remedy::kToken); }), 0);
  EXPECT_STREQ(lodestream_last_error(), "it requires a token; set the option token to a valid one");
}

}  // namespace
}  // namespace lode::embed
