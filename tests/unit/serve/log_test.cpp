#include "server/serve/ops/log.h"

#include <algorithm>
#include <array>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

namespace lode::serve {
namespace {

using namespace std::chrono_literals;

/// A pipe or a pair of sockets.
class LogTest : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    std::array<int, 2> ends{};
    ASSERT_EQ(GetParam() ? socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) : pipe(ends.data()), 0);
    reader_ = ends[0];
    writer_ = ends[1];
  }
  void TearDown() override {
    closeReader();
    close(writer_);
  }
  void closeReader() {
    if (reader_ >= 0) close(reader_);
    reader_ = -1;
  }
  LogOptions options() const {
    LogOptions options;
    options.descriptor = writer_;
    options.clock = [this] { return now_; };
    return options;
  }
  /// Reads everything. Call it after the log has ended.
  std::string readAll() {
    fcntl(reader_, F_SETFL, O_NONBLOCK);
    std::string text;
    std::array<char, 65536> part;
    for (ssize_t got = 0; (got = read(reader_, part.data(), part.size())) > 0;)
      text.append(part.data(), static_cast<size_t>(got));
    return text;
  }
  void fill() {
    const int flags = fcntl(writer_, F_GETFL);
    fcntl(writer_, F_SETFL, flags | O_NONBLOCK);
    const std::string much(4096, 'x');
    while (write(writer_, much.data(), much.size()) > 0) continue;
    fcntl(writer_, F_SETFL, flags);
  }

  int reader_ = -1, writer_ = -1;
  std::chrono::steady_clock::time_point now_{1000s};
};

size_t lines(const std::string& text) { return static_cast<size_t>(std::ranges::count(text, '\n')); }

TEST_P(LogTest, writesItsLinesInOrderBeforeItEnds) {
  {
    Log log(options());
    for (uint64_t i = 0; i < 20; ++i) log.write(LogKind::kServer, "line", {{"i", i}});
  }
  const std::string text = readAll();
  EXPECT_EQ(lines(text), 20u);
  EXPECT_LT(text.find("i=3)"), text.find("i=17)"));
}

TEST_P(LogTest, countsLostLinesAfterItsReaderIsGone) {
  closeReader();
  Log log(options());
  for (int i = 0; i < 20; ++i) log.write(LogKind::kServer, "nobody reads this");
  while (log.linesDropped() < 20) std::this_thread::yield();
  EXPECT_EQ(log.linesDropped(), 20u);
}

TEST_P(LogTest, neverWaitsForAStalledReader) {
  fill();
  {
    Log log(options());
    for (int i = 0; i < 20; ++i) log.write(LogKind::kServer, "nobody reads this");
    while (log.linesDropped() < 20) std::this_thread::yield();
  }
  EXPECT_EQ(readAll().find("nobody"), std::string::npos);
}

TEST_P(LogTest, reportsLostLinesOnceItsReaderContinues) {
  fill();
  {
    Log log(options());
    log.write(LogKind::kServer, "lost");
    while (log.linesDropped() < 1) std::this_thread::yield();
    readAll();
    log.write(LogKind::kServer, "heard");
  }
  const std::string text = readAll();
  EXPECT_NE(text.find("log lines were lost"), std::string::npos) << text;
  EXPECT_LT(text.find("(lines=1)"), text.find("heard")) << text;
}

TEST_P(LogTest, leavesTheFlagsThatOthersShareAsTheyAre) {
  const int before = fcntl(writer_, F_GETFL);
  const Log log(options());
  EXPECT_EQ(fcntl(writer_, F_GETFL), before);
}

TEST_P(LogTest, limitsLinesOfOneKindAndCountsTheRest) {
  {
    Log log(options());
    for (int i = 0; i < 10'000; ++i) log.write(LogKind::kDamagedStore, "a blob is damaged");
    EXPECT_EQ(log.linesLeftOut(), 9'950u);
    now_ += 1s;
    log.tick();
    log.tick();
  }
  const std::string text = readAll();
  EXPECT_EQ(lines(text), 51u);
  EXPECT_NE(text.find("damage: 9950 more like this were left out"), std::string::npos);
}

TEST_P(LogTest, saysHowManyMoreBeforeTheNextOfTheKind) {
  {
    Log log(options());
    for (int i = 0; i < 60; ++i) log.write(LogKind::kRefused, "full");
    now_ += 1s;
    log.write(LogKind::kRefused, "full again");
  }
  const std::string text = readAll();
  EXPECT_LT(text.find("10 more like this"), text.find("full again"));
}

TEST_P(LogTest, takesLinesFromManyThreads) {
  {
    Log log(options());
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&log] {
        for (int i = 0; i < 12; ++i) log.write(LogKind::kConnectionEnd, "ended");
      });
  }
  EXPECT_EQ(lines(readAll()), 48u);
}

TEST(LogReason, isDescribedForOperators) {
  EXPECT_EQ(reasonOf(std::bad_alloc()), "the system has no memory left");
  EXPECT_EQ(reasonOf(std::runtime_error("the disk is gone")), "the disk is gone");
}

INSTANTIATE_TEST_SUITE_P(ThroughA, LogTest, testing::Values(false, true),
                         [](const auto& about) { return about.param ? "Socket" : "Pipe"; });

constexpr auto kTime = std::chrono::sys_days(std::chrono::year(2026) / 11 / 22) + 3h + 18min + 12s + 7ms;
const std::vector<LogField> kFields{
    {"requests", uint64_t{12}}, {"seconds", 1.5}, {"peer", std::string_view("::1")}};

TEST(LogLine, hasTimeKindMessageAndFieldsInText) {
  EXPECT_EQ(
      logLine(false, kTime, LogKind::kConnectionEnd, "closed by the client", kFields),
      "2026-11-22T03:18:12.007Z connection: closed by the client (requests=12, seconds=1.5, peer=::1)\n");
  EXPECT_EQ(logLine(false, kTime, LogKind::kServer, "stopping", {}),
            "2026-11-22T03:18:12.007Z server: stopping\n");
}

TEST(LogLine, isOneObjectInJson) {
  const std::string line = logLine(true, kTime, LogKind::kDamagedStore, "a \"blob\"", kFields);
  EXPECT_EQ(std::ranges::count(line, '\n'), 1);
  EXPECT_EQ(nlohmann::ordered_json::parse(line),
            nlohmann::ordered_json::parse(
                R"({"time":"2026-11-22T03:18:12.007Z","kind":"damage","message":"a \"blob\"",
                    "requests":12,"seconds":1.5,"peer":"::1"})"));
}

TEST(LogLine, replacesLineBreaksAndTerminalControls) {
  for (const bool json : {false, true}) {
    const std::string line =
        logLine(json, kTime, LogKind::kRefused, "x\n2026 server: all is well\x1b[2J\xff", {});
    EXPECT_EQ(std::ranges::count(line, '\n'), 1);
    EXPECT_EQ(line.find('\x1b'), std::string::npos);
    EXPECT_EQ(line.find('\xff'), std::string::npos);
    EXPECT_NE(line.find("x?2026"), std::string::npos) << line;
  }
}

TEST(LogLine, isNeverLongerThanAnAtomicPipeWrite) {
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

const LogLimit::TimePoint kFirstLine{1000s};

/// Returns how many of `lines` lines are admitted.
int admitted(LogLimit& limit, LogKind kind, int lines, LogLimit::TimePoint now) {
  int count = 0;
  for (int i = 0; i < lines; ++i) count += limit.admit(kind, now);
  return count;
}

TEST(LogLimit, letsABurstThroughAndThenSoManyASecond) {
  LogLimit limit;
  EXPECT_EQ(admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine), 50);
  EXPECT_EQ(admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine + 1s), 5);
  EXPECT_EQ(admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine + 1s), 0);
  EXPECT_EQ(admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine + 1h), 50);
}

TEST(LogLimit, countsEachKindSeparately) {
  LogLimit limit;
  admitted(limit, LogKind::kDamagedStore, 10'000, kFirstLine);
  EXPECT_TRUE(limit.admit(LogKind::kRefused, kFirstLine));
}

TEST(LogLimit, reportsOmittedLinesOnceItAllowsMore) {
  LogLimit limit;
  admitted(limit, LogKind::kRefused, 60, kFirstLine);
  EXPECT_EQ(limit.takeLeftOut(LogKind::kRefused, kFirstLine), 0u);
  EXPECT_EQ(limit.takeLeftOut(LogKind::kRefused, kFirstLine + 1s), 10u);
  EXPECT_EQ(limit.takeLeftOut(LogKind::kRefused, kFirstLine + 2s), 0u);
  EXPECT_EQ(limit.takeLeftOut(LogKind::kDamagedStore, kFirstLine + 2s), 0u);
}

TEST(LogLimit, toleratesAClockThatStopsOrGoesBack) {
  LogLimit limit;
  EXPECT_EQ(admitted(limit, LogKind::kSystem, 100, kFirstLine), 50);
  EXPECT_EQ(admitted(limit, LogKind::kSystem, 100, kFirstLine - 10s), 0);
  EXPECT_EQ(admitted(limit, LogKind::kSystem, 100, kFirstLine + 1s), 5);
}

}  // namespace
}  // namespace lode::serve
