#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace lode::app {

/// How a program is started as a child.
struct ChildSetup {
  std::string input;       ///< what it reads from stdin, a file in memory that it may open anew
  int inherited = -1;      ///< a descriptor that stays open in it as long as it lives
  bool heeds_keys = true;  ///< a terminal's Ctrl-C and Ctrl-Z are for it too
};

/// A program started as a child. The kernel ends it when the thread that started it ends; the destructor ends
/// it, first gently. It reads a text that is given to it, or nothing; its stdout can be read; its stderr is
/// kept for messages, or goes to ours. Move only.
class ChildProcess {
 public:
  enum class Messages { kKeep, kPassOn };

  /// @throws Error kIo if it cannot be started.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               Messages messages, const ChildSetup& setup = {});
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  /// One line of its stdout, without the end of the line; empty if it ended or the time is over first.
  /// @throws Error kLimit if it is longer than kMaxLineBytes.
  std::string readLine(std::chrono::milliseconds timeout);
  /// Waits until it ends; what it writes to its stdout from now on fails.
  /// @return its exit status; 128 + the signal that killed it.
  int wait();
  /// Asks it to end; any thread may, while wait() was not called.
  void terminate() const noexcept;
  /// The last line of the messages kept so far, of at most kMaxMessageBytes.
  std::string lastMessage() const;

 private:
  pid_t process_ = -1;
  int output_ = -1;    // read end of its stdout
  std::string read_;   // of its stdout, after the last line
  int messages_ = -1;  // its stderr: a file in memory
};

constexpr size_t kMaxMessageBytes = 4096;
constexpr size_t kMaxLineBytes = size_t{64} << 20;  // a build names its images and may warn of each

/// What a lodestreamd that has failed said last; `otherwise` if it said nothing.
std::string saidBy(const ChildProcess& server, const std::string& otherwise);

/// The lodestreamd beside this program. @throws Error kIo if there is none.
std::filesystem::path siblingServer();

}  // namespace lode::app
