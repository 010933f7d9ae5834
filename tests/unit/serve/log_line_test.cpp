#include "server/serve/ops/log_line.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace lode::serve {
namespace {

using namespace std::chrono_literals;

constexpr auto kTime = std::chrono::sys_days(std::chrono::year(2026) / 11 / 22) + 3h + 18min + 12s + 7ms;
const std::vector<LogField> kFields{
    {"requests", uint64_t{12}}, {"seconds", 1.5}, {"peer", std::string_view("::1")}};

TEST(LogLine, inTextIsTimeKindMessageAndFields) {
  EXPECT_EQ(
      logLine(false, kTime, LogKind::kConnectionEnd, "closed by the client", kFields),
      "2026-11-22T03:18:12.007Z connection: closed by the client (requests=12, seconds=1.5, peer=::1)\n");
  EXPECT_EQ(logLine(false, kTime, LogKind::kServer, "stopping", {}),
            "2026-11-22T03:18:12.007Z server: stopping\n");
}

TEST(LogLine, inJsonIsOneObject) {
  const std::string line = logLine(true, kTime, LogKind::kDamagedStore, "a \"blob\"", kFields);
  EXPECT_EQ(std::ranges::count(line, '\n'), 1);
  EXPECT_EQ(nlohmann::ordered_json::parse(line),
            nlohmann::ordered_json::parse(
                R"({"time":"2026-11-22T03:18:12.007Z","kind":"damage","message":"a \"blob\"",
                    "requests":12,"seconds":1.5,"peer":"::1"})"));
}

TEST(LogLine, bearsNothingThatCouldForgeALineOrMoveACursor) {
  for (const bool json : {false, true}) {
    const std::string line =
        logLine(json, kTime, LogKind::kRefused, "x\n2026 server: all is well\x1b[2J\xff", {});
    EXPECT_EQ(std::ranges::count(line, '\n'), 1);
    EXPECT_EQ(line.find('\x1b'), std::string::npos);
    EXPECT_EQ(line.find('\xff'), std::string::npos);
    EXPECT_NE(line.find("x?2026"), std::string::npos) << line;
  }
}

TEST(LogLine, neverIsLongerThanAPipeTakesWhole) {
  const std::string quotes(100'000, '"');
  const std::vector<LogField> fields(7, LogField{"field", std::string_view(quotes)});
  for (const bool json : {false, true}) {
    const std::string line = logLine(json, kTime, LogKind::kServer, quotes, fields);
    EXPECT_LE(line.size(), kMaxLogLineBytes);
    EXPECT_EQ(line.back(), '\n');
  }
}

TEST(LogLine, namesEveryKindDifferently) {
  std::vector<std::string_view> names;
  for (size_t kind = 0; kind < kLogKinds; ++kind) names.push_back(logKindName(static_cast<LogKind>(kind)));
  std::ranges::sort(names);
  EXPECT_EQ(std::ranges::adjacent_find(names), names.end());
}

}  // namespace
}  // namespace lode::serve
