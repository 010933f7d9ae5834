#pragma once

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace lode::app {

/// Options for starting a child process.
struct ChildSetup {
  /// Contents of the child's stdin. Stdin is an in-memory file, so the child can also open it as
  /// /proc/self/fd/0.
  std::string input;
  int inherited = -1;       ///< file descriptor that the child inherits; -1: none
  bool heeds_keys = true;   ///< true if Ctrl-C and Ctrl-Z in the terminal also reach the child
  bool is_private = false;  ///< true to let only this user read the files that the child creates
  bool yields = false;      ///< true to run at a low priority, so that this program stays responsive
};

/// A child process. The destructor sends SIGTERM, then SIGKILL if the child does not end in time. The kernel
/// also sends SIGTERM when the thread that started the child ends. The parent reads the child's stdout line
/// by line, and either keeps the child's stderr or passes it through. Move only.
class ChildProcess {
 public:
  enum class Messages {
    kKeep,   ///< keep the child's stderr for lastMessage()
    kPassOn  ///< let the child write to this program's stderr
  };

  /// Starts the process. @throws Error kIo if the program cannot be started.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               Messages messages, const ChildSetup& setup = {});
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  /// Returns the next line of the child's stdout without the newline, or an empty string at the end of stdout
  /// or after the timeout. @throws Error kLimit if the line exceeds kMaxLineBytes.
  std::string readLine(std::chrono::milliseconds timeout);
  /// Closes the child's stdout and waits until the child ends.
  /// @return the exit status, or 128 plus the number of the signal that killed the child.
  int wait();
  /// Sends a signal. Any thread may call this function until wait() is called.
  void signal(int number) const noexcept;
  void terminate() const noexcept { signal(SIGTERM); }
  /// Returns the last line of the child's kept stderr, at most kMaxMessageBytes.
  std::string lastMessage() const;

 private:
  pid_t process_ = -1;
  int output_ = -1;    // read end of the child's stdout
  std::string read_;   // bytes read from the child's stdout but not yet returned
  int messages_ = -1;  // the child's stderr, an in-memory file
};

constexpr size_t kMaxMessageBytes = 4096;
// Large, because one line lists all warnings of a build, possibly one for each image.
constexpr size_t kMaxLineBytes = size_t{64} << 20;

/// Returns the last message of a failed lodestreamd, or `otherwise` if the process wrote no message.
std::string saidBy(const ChildProcess& server, const std::string& otherwise);

/// Returns the path of lodestreamd in this program's folder. @throws Error kIo if the file is missing or not
/// executable.
std::filesystem::path siblingServer();

}  // namespace lode::app
