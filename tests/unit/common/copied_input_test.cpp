#include "common/io/copied_input.h"

#include <array>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "common/error.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

namespace lode {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kPlenty = 1 << 30;

/// A pipe, with a thread that writes a text over and over until all of it is written or nobody reads it.
class Sender {
 public:
  explicit Sender(std::string text, uint64_t times = 1) {
    std::signal(SIGPIPE, SIG_IGN);
    EXPECT_EQ(pipe2(ends_.data(), O_CLOEXEC), 0);
    thread_ = std::thread([this, text = std::move(text), times] {
      for (uint64_t i = 0; i < times; ++i)
        if (write(ends_[1], text.data(), text.size()) < 0) break;
      close(ends_[1]);
    });
  }
  ~Sender() {
    close(ends_[0]);
    thread_.join();
  }
  Sender(Sender&&) = delete;
  Sender& operator=(Sender&&) = delete;

  int output() const { return ends_[0]; }

 private:
  std::array<int, 2> ends_{};
  std::thread thread_;
};

class CopyOfInput : public testing::Test {
 protected:
  /// @return the error of a copy.
  Error refusal(int input, uint64_t max_bytes = kPlenty) const {
    try {
      const CopiedInput copied(input, folder_.path(), max_bytes);
    } catch (const Error& error) {
      return error;
    }
    ADD_FAILURE() << "the input was copied";
    return {ErrorCode::kInternal, ""};
  }

  const test::WorkFolder folder_;
};

TEST_F(CopyOfInput, hasTheBytesOfThePipe) {
  std::string text = "ply\nformat ascii 1.0\n";
  for (int i = 0; i < 1 << 20; ++i) text += std::to_string(i * 2654435761u % 1000);
  const Sender sender(text);
  const CopiedInput copied(sender.output(), folder_.path(), kPlenty);
  EXPECT_TRUE(test::readBytes(copied.path()) == text);
}

TEST_F(CopyOfInput, isRemovedWithItsFolder) {
  {
    const Sender sender("ply\n");
    const CopiedInput copied(sender.output(), folder_.path(), kPlenty);
    EXPECT_TRUE(fs::exists(copied.path()));
  }
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(CopyOfInput, endsAtItsLimitWhenTheInputHasNoEnd) {
  const Sender sender("ply\n" + std::string(4092, '0'), UINT64_MAX);
  const Error error = refusal(sender.output(), 5 << 20);
  EXPECT_EQ(error.code(), ErrorCode::kLimit);
  EXPECT_NE(std::string(error.what()).find("longer than 5.2 MB"), std::string::npos) << error.what();
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(CopyOfInput, isRefusedAfterTheFirstBytesOfAnotherFile) {
  const Sender sender("solid of another format\n", UINT64_MAX);
  const Error error = refusal(sender.output());
  EXPECT_EQ(error.code(), ErrorCode::kInput);
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(CopyOfInput, needsAtLeastOneByte) {
  const Sender sender("");
  EXPECT_EQ(refusal(sender.output()).code(), ErrorCode::kInput);
}

TEST_F(CopyOfInput, isRefusedOnATerminal) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(unlockpt(terminal), 0);
  const int input = open(ptsname(terminal), O_RDWR | O_NOCTTY);
  ASSERT_GE(input, 0);
  EXPECT_EQ(refusal(input).code(), ErrorCode::kUsage);
  close(input);
  close(terminal);
}

TEST_F(CopyOfInput, thatCannotBeReadIsAnError) {
  const int folder = open(folder_.path().c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_GE(folder, 0);
  EXPECT_EQ(refusal(folder).code(), ErrorCode::kIo);
  close(folder);
}

}  // namespace
}  // namespace lode
