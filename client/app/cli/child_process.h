#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace lode::app {

/// Setup of a child process.
struct ChildSetup {
  std::string input;       ///< contents of its stdin, an in-memory file that it may reopen
  int inherited = -1;      ///< a descriptor that the child inherits
  bool heeds_keys = true;  ///< gets a terminal's Ctrl-C and Ctrl-Z
};

/// A child process. The destructor ends it, first with SIGTERM; the kernel kills it when the thread that
/// started it ends. Its stdout is readable line by line; its stderr is kept or passed on. Move only.
class ChildProcess {
 public:
  enum class Messages { kKeep, kPassOn };

  /// @throws Error kIo if it cannot be started.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               Messages messages, const ChildSetup& setup = {});
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  /// Returns the next line of its stdout without the newline, or an empty string at its end or after the
  /// timeout. @throws Error kLimit if the line exceeds kMaxLineBytes.
  std::string readLine(std::chrono::milliseconds timeout);
  /// Closes its stdout and waits until it ends.
  /// @return its exit status, or 128 + the signal that killed it.
  int wait();
  /// Sends SIGTERM. Any thread may call it before wait().
  void terminate() const noexcept;
  /// Returns the last line of its kept stderr, at most kMaxMessageBytes.
  std::string lastMessage() const;

 private:
  pid_t process_ = -1;
  int output_ = -1;    // read end of its stdout
  std::string read_;   // bytes of its stdout after the last line
  int messages_ = -1;  // its stderr, an in-memory file
};

constexpr size_t kMaxMessageBytes = 4096;
constexpr size_t kMaxLineBytes = size_t{64} << 20;  // a build may warn about each of its images

/// Returns the last message of a failed lodestreamd, or `otherwise` if it has none.
std::string saidBy(const ChildProcess& server, const std::string& otherwise);

/// Returns the path of the lodestreamd beside this program. @throws Error kIo if it is missing.
std::filesystem::path siblingServer();

}  // namespace lode::app
