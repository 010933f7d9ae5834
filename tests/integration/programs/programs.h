#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

/// Runs the two programs as a script does, with arguments as they are (no shell), and without waiting for
/// ever.
namespace lode::test {

constexpr std::chrono::seconds kPatience{600};  ///< what takes longer hangs

void writeBytes(const std::filesystem::path& file, std::string_view bytes);

/// How a program ended. One that did not end in time was killed, and has failed the running test.
struct Outcome {
  int status = -1;  ///< 128 + the signal that ended it
  std::string out, err;
};

/// A program that is running; killed with this object, or with the test whatever ends that.
class Program {
 public:
  /// @param name         of a program under test, or of one on the PATH.
  /// @param environment  "NAME=value" on top of the test's own.
  Program(const std::string& name, const std::vector<std::string>& arguments,
          const std::vector<std::string>& environment = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Waits for a line on its stdout. @return what has come; without a line end if it ended or was too slow.
  std::string readLine();
  void signal(int number) const;
  /// Waits until it ends. Its stdout is what was not read before.
  Outcome wait();

 private:
  pid_t process_ = -1;
  int handle_ = -1;  // of the process, for poll()
  int out_ = -1;     // read end of its stdout
  int err_ = -1;     // its stderr: a file in memory
};

Outcome lodestreamd(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment = {});
/// Begins with an empty cache, unless the environment names one.
Outcome lodestream(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment = {});

/// lodestreamd serve on a port of loopback that it picks.
class RunningServer {
 public:
  /// @param more  options.
  explicit RunningServer(const std::vector<std::filesystem::path>& stores,
                         const std::vector<std::string>& more = {});

  const std::string& address() const noexcept { return address_; }
  std::string url(std::string_view model = {}) const;
  /// Asks it to end, as an operator does.
  Outcome stop();
  void kill();

 private:
  Program program_;
  std::string address_;
};

/// Waits until a folder, or one below it, has a file whose path ends so. @return its path.
std::filesystem::path waitForFile(const std::filesystem::path& folder, std::string_view ending);

using Processes = std::map<pid_t, std::string>;  ///< their command lines

/// All running processes in whose command line the text occurs.
Processes processesNaming(std::string_view text);

/// Fails the running test unless the work failed as the command lines promise: exit 1, nothing on stdout, and
/// one line on stderr in which each of `named` occurs.
void expectFailure(const Outcome& outcome, const std::vector<std::string>& named);

/// Fails the running test unless the text is one line.
void expectOneLine(const std::string& text);

/// A small closed model of several nodes, with colours and normals: small.ply and, returned, small.lode.
std::filesystem::path makeSmallStore(const WorkFolder& folder);

}  // namespace lode::test
