#include "client/core/view/strict_json.h"

#include <gtest/gtest.h>

namespace lode::core {
namespace {

std::string problemOf(std::string_view text) {
  std::string problem;
  parseStrictly<nlohmann::json>(text, problem);
  return problem;
}

TEST(StrictJson, namesThePlaceOfASyntaxError) {
  EXPECT_EQ(problemOf("{\n  \"a\": 1,\n  \"b\": ?\n}"), "not JSON at line 3, column 8");
  EXPECT_EQ(problemOf(""), "not JSON at line 1, column 1");
  EXPECT_EQ(problemOf("{\"a\": 1"), "not JSON at line 1, column 8");
}

TEST(StrictJson, refusesANameThatAnObjectHasTwice) {
  EXPECT_EQ(problemOf(R"({"a": [{"b": 1}, {"b": 2}], "b": 3})"), "");
  EXPECT_EQ(problemOf(R"({"a": {"b": 1, "c": 2, "b": 3}})"), R"("b" appears twice)");
}

TEST(StrictJson, refusesANumberThatNoDoubleHolds) {
  EXPECT_EQ(problemOf("[1e999]"), "a number is too large");
}

}  // namespace
}  // namespace lode::core
