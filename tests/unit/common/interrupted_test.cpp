#include "common/io/interrupted.h"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <utility>

#include <gtest/gtest.h>

#include "common/io/atomic_file.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

namespace lode {
namespace {

namespace fs = std::filesystem;

/// Runs functions in child processes that a signal ends.
class Interrupted : public testing::Test {
 protected:
  void fill(const fs::path& folder) const {
    fs::create_directories(folder / "deeper/still");
    for (int i = 0; i < 200; ++i) std::ofstream(folder / ("a file of some name " + std::to_string(i))) << "x";
    std::ofstream(folder / "deeper/still/b") << "x";
  }

  test::WorkFolder folder_;
  const testing::KilledBySignal by_sigterm_{SIGTERM};
};

TEST_F(Interrupted, processesPrintALineAndEndByTheSignal) {
  EXPECT_EXIT(
      {
        endCleanlyWhenInterrupted();
        std::raise(SIGTERM);
      },
      by_sigterm_, "unit_common: interrupted\n$");
}

TEST_F(Interrupted, processesLeaveNothingOfAFileThatIsBeingWritten) {
  EXPECT_EXIT(
      {
        AtomicFile file(folder_ / "a");
        file.write(test::bytesOf("half of it"));
        std::raise(SIGTERM);
      },
      by_sigterm_, "unfinished output is removed");
  EXPECT_TRUE(folder_.contents().empty());
}

TEST_F(Interrupted, processesSayNothingOfFilesThatWereNotBegun) {
  EXPECT_EXIT(
      {
        endCleanlyWhenInterrupted();
        const Unfinished unfinished(folder_ / "a");
        std::raise(SIGTERM);
      },
      by_sigterm_, "unit_common: interrupted\n$");
}

TEST_F(Interrupted, processesRemoveAFolderWithAllThatIsInIt) {
  EXPECT_EXIT(
      {
        fill(folder_ / "folder");
        const Unfinished unfinished(folder_ / "folder");
        std::raise(SIGTERM);
      },
      by_sigterm_, "");
  EXPECT_TRUE(folder_.contents().empty());
}

TEST_F(Interrupted, processesKeepFinishedFiles) {
  EXPECT_EXIT(
      {
        AtomicFile file(folder_ / "a");
        file.commit();
        std::ofstream(folder_ / "b") << "x";
        Unfinished given(folder_ / "b");
        Unfinished taken(std::move(given));
        taken.finish();
        std::raise(SIGTERM);
      },
      by_sigterm_, "");
  EXPECT_EQ(folder_.contents().size(), 2u);
}

TEST_F(Interrupted, processesKeepIgnoringAnIgnoredSignal) {
  EXPECT_EXIT(
      {
        std::signal(SIGHUP, SIG_IGN);
        endCleanlyWhenInterrupted();
        std::raise(SIGHUP);
        std::exit(7);
      },
      testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace lode
