#include "client/app/cli/child_process.h"

#include <array>
#include <csignal>
#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace lode::app {
namespace {

using namespace std::chrono_literals;

ChildProcess shell(const std::string& script) {
  return {"/bin/sh", {"-c", script}, ChildProcess::Messages::kKeep};
}

TEST(ChildProcess, isReadLineByLine) {
  ChildProcess child = shell("printf 'one\\ntwo\\nrest'");
  EXPECT_EQ(child.readLine(300s), "one");
  EXPECT_EQ(child.readLine(300s), "two");
  EXPECT_EQ(child.readLine(300s), "");  // no end of the line
  EXPECT_EQ(child.wait(), 0);
}

TEST(ChildProcess, readsItsInputAndCanReopenIt) {
  ChildProcess child("/bin/sh", {"-c", "cat; cat /proc/self/fd/0"}, ChildProcess::Messages::kKeep,
                     {.input = "text\n"});
  EXPECT_EQ(child.readLine(300s), "text");
  EXPECT_EQ(child.readLine(300s), "text");
}

TEST(ChildProcess, isReadLineByLineEvenIfALineIsLong) {
  ChildProcess child = shell("head -c 3000000 /dev/zero | tr '\\0' x; echo; echo next");
  EXPECT_EQ(child.readLine(300s).size(), 3'000'000u);
  EXPECT_EQ(child.readLine(300s), "next");
}

TEST(ChildProcess, endsWhenWaitedForEvenIfItsOutputIsUnread) {
  ChildProcess child = shell("yes");
  EXPECT_EQ(child.readLine(300s), "y");
  EXPECT_EQ(child.wait(), 128 + SIGPIPE);
}

TEST(ChildProcess, keepsADescriptorOpenThatItInherits) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
  ChildProcess child("/bin/sh", {"-c", "echo still here > /proc/self/fd/" + std::to_string(ends[1])},
                     ChildProcess::Messages::kKeep, {.input = {}, .inherited = ends[1]});
  close(ends[1]);
  EXPECT_EQ(child.wait(), 0);
  std::array<char, 64> said{};
  EXPECT_EQ(read(ends[0], said.data(), said.size()), 11);
  close(ends[0]);
}

TEST(ChildProcess, reportsItsExitStatus) {
  EXPECT_EQ(shell("exit 3").wait(), 3);
  EXPECT_EQ(shell("kill -9 $$").wait(), 128 + SIGKILL);
}

TEST(ChildProcess, keepsTheLastLineThatItSaidOnStderr) {
  ChildProcess child = shell("echo first >&2; echo last >&2; exit 1");
  child.wait();
  EXPECT_EQ(child.lastMessage(), "last");
}

TEST(ChildProcess, keepsNoMoreOfItsMessagesThanTheLimit) {
  ChildProcess child = shell("head -c 100000 /dev/zero | tr '\\0' x >&2");
  child.wait();
  EXPECT_EQ(child.lastMessage(), std::string(kMaxMessageBytes, 'x'));
}

TEST(ChildProcess, isReadNoLongerThanTheTimeout) {
  ChildProcess child = shell("exec sleep 1000");
  EXPECT_EQ(child.readLine(10ms), "");
}

TEST(ChildProcess, endsWhenAsked) {
  ChildProcess child = shell("exec sleep 1000");
  child.terminate();
  EXPECT_EQ(child.wait(), 128 + SIGTERM);
}

TEST(ChildProcess, endsWhenItsObjectIsDestroyed) {
  pid_t process = 0;
  {
    ChildProcess child = shell("echo $$; exec sleep 1000");
    process = static_cast<pid_t>(std::stol(child.readLine(300s)));
    EXPECT_EQ(kill(process, 0), 0);
  }
  EXPECT_EQ(kill(process, 0), -1);
}

TEST(ChildProcess, leavesTheProcessGroupOnlyIfItIgnoresTheTerminalsKeys) {
  for (const bool heeds_keys : {true, false}) {
    ChildSetup setup;
    setup.heeds_keys = heeds_keys;
    ChildProcess child("/bin/sh", {"-c", "echo $$; exec sleep 1000"}, ChildProcess::Messages::kKeep, setup);
    const auto process = static_cast<pid_t>(std::stol(child.readLine(300s)));
    EXPECT_EQ(getpgid(process) == getpgrp(), heeds_keys);
  }
}

TEST(ChildProcess, endsWithStatus127IfItsProgramIsMissing) {
  ChildProcess child("/nowhere/program", {}, ChildProcess::Messages::kKeep);
  EXPECT_EQ(child.wait(), 127);
}

}  // namespace
}  // namespace lode::app
