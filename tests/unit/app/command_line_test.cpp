#include "common/command_line.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace lode {
namespace {

/// A program with one command, `work`, which has the flag `--fast` and calls a function of the test.
class ACommandLine : public testing::Test {
 protected:
  void run(std::vector<const char*> words, const std::function<void(int& exit_status)>& work = {},
           std::string (*message_of)(const Error&) = command_line::plainMessage) {
    CLI::App program("what it is for", "tool");
    words.insert(words.begin(), "tool");
    const auto declare = [&](int& exit_status) {
      CLI::App* command = program.add_subcommand("work", "what it does");
      command->add_flag("--fast");
      command->add_option("thing", thing_);
      command->callback([&] {
        if (work) work(exit_status);
      });
    };
    testing::internal::CaptureStderr();
    status_ = runCommandLine(program, static_cast<int>(words.size()), words.data(), declare,
                             {"take less", message_of, default_command_});
    said_ = testing::internal::GetCapturedStderr();
  }

  DefaultCommand default_command_;
  int status_ = -1;
  std::string thing_;  ///< argument of the command
  std::string said_;   ///< the program's stderr
};

TEST_F(ACommandLine, pointsToTheHelpOfItsCommandOnWrongUsage) {
  run({"work", "--slow"});
  EXPECT_EQ(said_, "tool: not known here: --slow: see tool work --help\n");
  EXPECT_EQ(status_, 2);
}

TEST_F(ACommandLine, pointsToTheHelpOfTheProgramWithoutACommand) {
  run({});
  EXPECT_NE(said_.find(": see tool --help\n"), std::string::npos) << said_;
  EXPECT_EQ(status_, 2);
}

TEST_F(ACommandLine, namesAMistypedCommand) {
  for (const DefaultCommand& command :
       {DefaultCommand(), DefaultCommand{"work", [](auto) { return false; }}}) {
    default_command_ = command;
    run({"wrok", "x"});
    EXPECT_EQ(said_, "tool: unknown command: wrok: see tool --help\n");
    EXPECT_EQ(status_, 2);
  }
}

TEST_F(ACommandLine, runsTheDefaultCommandForItsArgument) {
  default_command_ = {"work", [](std::string_view word) { return word == "a.b"; }};
  run({"a.b", "--fast"});
  EXPECT_EQ(status_, 0) << said_;
  EXPECT_EQ(thing_, "a.b");
  run({"a.b", "--slow"});
  EXPECT_EQ(said_, "tool: not known here: --slow: see tool work --help\n");
}

TEST_F(ACommandLine, prefersACommandToTheDefaultCommand) {
  default_command_ = {"work", [](std::string_view) { return true; }};
  run({"work", "x"});
  EXPECT_EQ(thing_, "x");
  run({"--fast", "x"});
  EXPECT_EQ(said_, "tool: not known here: --fast x: see tool --help\n");
  run({""});
  EXPECT_EQ(status_, 0) << said_;
  run({"-"});
  EXPECT_EQ(thing_, "-");
}

TEST_F(ACommandLine, reportsAFailureInOneLine) {
  run({"work"}, [](int&) { throw Error(ErrorCode::kIo, "the disk\nis full"); });
  EXPECT_EQ(said_, "tool: the disk is full\n");
  EXPECT_EQ(status_, 1);
}

TEST_F(ACommandLine, ofAProgramWithRemediesPutsThemInItsWords) {
  run(
      {"work"}, [](int&) { throw Error(ErrorCode::kIo, "no token", Remedy::kToken); },
      [](const Error& error) { return error.what() + std::string("; ask for one"); });
  EXPECT_EQ(said_, "tool: no token; ask for one\n");
}

TEST_F(ACommandLine, exitsWithStatus2OnAUsageError) {
  run({"work"}, [](int&) { throw Error(ErrorCode::kUsage, "it has no camera"); });
  EXPECT_EQ(status_, 2);
}

TEST_F(ACommandLine, advisesWhatToDoWhenOutOfMemory) {
  run({"work"}, [](int&) { throw std::bad_alloc(); });
  EXPECT_EQ(said_, "tool: out of memory: take less\n");
  EXPECT_EQ(status_, 1);
}

TEST_F(ACommandLine, exitsWithTheStatusOfItsCommand) {
  run({"work", "--fast"}, [](int& exit_status) { exit_status = 130; });
  EXPECT_EQ(said_, "");
  EXPECT_EQ(status_, 130);
}

TEST(NumberFrom, acceptsOnlyNumbersInItsRange) {
  const CLI::Validator check = numberFrom(0.5, 4);
  for (std::string text : {"0.5", "4", "1e0"}) EXPECT_EQ(check(text), "") << text;
  for (std::string text : {"nan", "-nan", "inf", "0.49", "4.1", "", "two", "1x"})
    EXPECT_EQ(check(text), "must be a number in [0.5 - 4], not " + text);
}

}  // namespace
}  // namespace lode
