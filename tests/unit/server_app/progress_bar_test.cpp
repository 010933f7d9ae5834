#include "server/app/progress_bar.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using namespace std::chrono_literals;

/// A progress bar with a scripted clock that writes to memory.
class Printed {
 public:
  explicit Printed(ProgressBar::Mode mode, const std::optional<ingest::BuildEstimate>& build = {})
      : file_(open_memstream(&text_, &size_)), bar_(file_, mode, build, [this] { return now_; }) {}
  ~Printed() {
    std::fclose(file_);
    std::free(text_);
  }
  Printed(const Printed&) = delete;
  Printed& operator=(const Printed&) = delete;

  /// Reports a stage every 100 ms for a given time. @return the text printed meanwhile.
  std::string run(std::string_view stage, std::chrono::milliseconds time) {
    const size_t before = text().size();
    constexpr auto kStep = 100ms;
    for (auto ran = kStep; ran <= time; ran += kStep) {
      now_ += kStep;
      const double fraction = static_cast<double>(ran.count()) / static_cast<double>(time.count());
      bar_.update(stage, fraction, static_cast<uint64_t>(2e6 * fraction), 2'000'000);
    }
    return text().substr(before);
  }
  std::string finish() {
    const size_t before = text().size();
    bar_.finish();
    return text().substr(before);
  }

 private:
  std::string text() {
    std::fflush(file_);
    return {text_, size_};
  }

  char* text_ = nullptr;
  size_t size_ = 0;
  std::FILE* file_;
  ProgressBar::Clock::time_point now_{1h};
  ProgressBar bar_;
};

const ingest::BuildEstimate kBuild(2);

long linesIn(const std::string& text) { return std::ranges::count(text, '\n'); }

TEST(ProgressBar, printsALineEveryFiveSecondsIfItsOutputIsNoTerminal) {
  Printed printed(ProgressBar::Mode::kLines, kBuild);
  EXPECT_EQ(linesIn(printed.run("simplify", 4900ms)), 0);
  EXPECT_EQ(linesIn(printed.run("simplify", 60s)), 12);
}

TEST(ProgressBar, printsLinesInABuildOfShortStages) {
  Printed printed(ProgressBar::Mode::kLines, kBuild);
  std::string text;
  for (const char* stage : {"scan", "dereference", "sort", "partition", "border", "simplify", "pack"})
    text += printed.run(stage, 2s);
  EXPECT_EQ(linesIn(text), 2) << "14 s: " << text;
}

TEST(ProgressBar, printsPercentageTrianglesRateAndTimeLeft) {
  Printed printed(ProgressBar::Mode::kLines, kBuild);
  printed.run("scan", 500ms);
  printed.run("partition", 2s);
  const std::string text = printed.run("simplify", 40s);
  const std::string first = text.substr(0, text.find('\n'));
  EXPECT_TRUE(first.starts_with("simplifying")) << first;
  for (const char* part : {" %  ", " k of 2.0 M triangles  ", " k/s  ", " left"})
    EXPECT_NE(first.find(part), std::string::npos) << part << " in: " << first;
}

TEST(ProgressBar, drawsOneBarForTheWholeBuild) {
  Printed printed(ProgressBar::Mode::kBar, kBuild);
  std::string text;
  for (const char* stage : {"scan", "dereference", "sort", "partition", "simplify", "pack"})
    text += printed.run(stage, 2s);
  EXPECT_EQ(linesIn(text), 0);
  const std::string end = printed.finish();
  EXPECT_EQ(linesIn(end), 1);
  EXPECT_NE(end.find("100 %"), std::string::npos) << end;
  EXPECT_NE(end.find("0:12"), std::string::npos) << end;
}

TEST(ProgressBar, drawsABarOfEachStageThatStandsAlone) {
  Printed printed(ProgressBar::Mode::kBar);
  printed.run("lods", 2s);
  EXPECT_EQ(linesIn(printed.run("boundaries", 2s)), 1);
  EXPECT_EQ(linesIn(printed.finish()), 1);
}

TEST(ProgressBar, printsTheStageAndTheBuildAsJson) {
  Printed printed(ProgressBar::Mode::kJson, kBuild);
  const std::string text = printed.run("scan", 100ms) + printed.run("sort", 100ms);
  const std::string first = text.substr(0, text.find('\n'));
  EXPECT_TRUE(first.starts_with(R"({"stage":"scan","fraction":1.0,"doing":"reading the file",)")) << first;
  const std::string end = printed.finish();
  EXPECT_EQ(end, "") << "the last stage is printed as done";
}

TEST(ProgressBar, fitsIntoATerminalOfEightyColumns) {
  const ingest::BuildStatus status{.doing = "dividing the model",
                                   .fraction = 0.999,
                                   .seconds_left = 35999,
                                   .done = 999.9e6,
                                   .total = 1e9,
                                   .unit = "triangles",
                                   .items_per_s = 999.9e3};
  EXPECT_LT(describeBuild(status, 36000, 10).size(), 80) << describeBuild(status, 36000, 10);
}

TEST(ProgressBar, showsBytesWithTheirUnit) {
  ingest::BuildStatus status;
  status.doing = "reading the file";
  status.fraction = 0.01;
  status.done = 12.3e6;
  status.total = 380e6;
  status.unit = "B";
  EXPECT_EQ(describeBuild(status, 0.2, 0), "reading the file      1 %  12.3 M of 380 MB");
}

}  // namespace
}  // namespace lode::app
