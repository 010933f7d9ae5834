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

/// Runs the two programs as a script does. Passes arguments without a shell, and never waits for ever.
namespace lode::test {

constexpr std::chrono::seconds kPatience{600};  ///< a program that takes longer counts as hung

void writeBytes(const std::filesystem::path& file, std::string_view bytes);

/// The end of a program. A program that did not end in time was killed and has failed the running test.
struct Outcome {
  int status = -1;  ///< exit status, or 128 + the signal that ended the program
  std::string out, err;
};

/// A running program. The end of this object or of the test process kills the program.
class Program {
 public:
  /// @param name         name of a program under test, or of a program on the PATH.
  /// @param environment  variables "NAME=value", added to the environment of the test.
  Program(const std::string& name, const std::vector<std::string>& arguments,
          const std::vector<std::string>& environment = {});
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Waits for a line on the program's stdout. @return the line; without a line end if the program ended or
  /// was too slow.
  std::string readLine();
  void signal(int number) const;
  /// Waits until the program ends. The outcome's stdout has only the text that readLine() has not returned.
  Outcome wait();

 private:
  pid_t process_ = -1;
  int handle_ = -1;  // handle of the process, for poll()
  int out_ = -1;     // read end of the program's stdout
  int err_ = -1;     // the program's stderr, a file in memory
};

Outcome lodestreamd(const std::vector<std::string>& arguments,
                    const std::vector<std::string>& environment = {});
/// Runs lodestream. The cache is empty at the start, unless the environment names a cache.
Outcome lodestream(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment = {});

/// Runs lodestreamd serve on a free loopback port.
class RunningServer {
 public:
  /// @param more  further options.
  explicit RunningServer(const std::vector<std::filesystem::path>& stores,
                         const std::vector<std::string>& more = {});

  const std::string& address() const noexcept { return address_; }
  std::string url(std::string_view model = {}) const;
  /// Stops the server as an operator does.
  Outcome stop();
  void kill();

 private:
  Program program_;
  std::string address_;
};

/// Waits until a folder contains, at any depth, a file whose path ends with `ending`. @return the path of the
/// file.
std::filesystem::path waitForFile(const std::filesystem::path& folder, std::string_view ending);

using Processes = std::map<pid_t, std::string>;  ///< command lines by process id

/// Returns all running processes whose command line contains a text.
Processes processesNaming(std::string_view text);

/// Expects that a command failed as documented: exit status 1, nothing on stdout, and one line on stderr that
/// contains each of `named`.
void expectFailure(const Outcome& outcome, const std::vector<std::string>& named);

/// Expects that a text has one line.
void expectOneLine(const std::string& text);

/// Makes a small closed model of several nodes with colours and normals: small.ply and small.lode. @return
/// the path of small.lode.
std::filesystem::path makeSmallStore(const WorkFolder& folder);

}  // namespace lode::test
