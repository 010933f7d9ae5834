#include "client/app/cli/child_process.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.h"

namespace lode::app {
namespace {

constexpr std::chrono::milliseconds kGentleEnd{3000};
constexpr std::chrono::milliseconds kPoll{10};
constexpr int kCannotStart = 127;
constexpr int kLowPriority = 10;  ///< nice value

[[noreturn]] void refuse(const std::filesystem::path& program) {
  throw Error(ErrorCode::kIo, program.string() + " cannot be started: " + std::strerror(errno));
}

/// Resets the signals that this program handles. Ignored signals stay ignored, as after exec.
void resetHandlers() {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (sigaction(number, nullptr, &action) == 0 && action.sa_handler != SIG_IGN)
      std::signal(number, SIG_DFL);
  }
}

/// Replaces the forked child by the program. Makes only calls that are safe between fork and exec.
[[noreturn]] void become(char* const* arguments, int input, int output, int messages, pid_t parent,
                         const ChildSetup& setup) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kCannotStart);
  // Put the child into a new process group, because a terminal sends its signals to a whole group.
  if (!setup.heeds_keys) setpgid(0, 0);
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  if (messages >= 0) dup2(messages, STDERR_FILENO);
  if (setup.is_private) umask(S_IRWXG | S_IRWXO);
  if (setup.yields) setpriority(PRIO_PROCESS, 0, kLowPriority);
  if (setup.inherited >= 0) fcntl(setup.inherited, F_SETFD, 0);
  execv(arguments[0], arguments);
  _exit(kCannotStart);
}

/// Creates an in-memory file that contains a text. @return the file's descriptor, at offset 0; negative on
/// failure.
int fileOf(const std::string& text) {
  const int file = memfd_create("lodestream input", MFD_CLOEXEC);
  if (file < 0) return file;
  if (write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
      lseek(file, 0, SEEK_SET) == 0)
    return file;
  close(file);
  return -1;
}

int exitStatus(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

}  // namespace

ChildProcess::ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                           Messages messages, const ChildSetup& setup) {
  std::vector<std::string> texts{program.string()};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);

  std::array<int, 2> pipe_ends{};
  const int input_file = fileOf(setup.input);
  if (input_file < 0) refuse(program);
  if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0) {
    close(input_file);
    refuse(program);
  }
  output_ = pipe_ends[0];
  if (messages == Messages::kKeep) messages_ = memfd_create("lodestreamd messages", MFD_CLOEXEC);
  const pid_t parent = getpid();
  // Until the child runs its own program, a signal would run this program's handler there.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  process_ = fork();
  if (process_ == 0) {
    resetHandlers();
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    become(pointers.data(), input_file, pipe_ends[1], messages_, parent, setup);
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  close(input_file);
  close(pipe_ends[1]);
  if (process_ < 0) {
    close(output_);
    if (messages_ >= 0) close(messages_);
    refuse(program);
  }
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      output_(std::exchange(other.output_, -1)),
      read_(std::move(other.read_)),
      messages_(std::exchange(other.messages_, -1)) {}

ChildProcess::~ChildProcess() {
  if (process_ > 0) {
    kill(process_, SIGTERM);
    const auto deadline = std::chrono::steady_clock::now() + kGentleEnd;
    int status = 0;
    while (waitpid(process_, &status, WNOHANG) == 0) {
      if (std::chrono::steady_clock::now() > deadline) kill(process_, SIGKILL);
      std::this_thread::sleep_for(kPoll);
    }
  }
  if (output_ >= 0) close(output_);
  if (messages_ >= 0) close(messages_);
}

std::string ChildProcess::readLine(std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  std::array<char, 4096> bytes;
  for (size_t looked_at = 0;;) {
    const size_t end = read_.find('\n', looked_at);
    if (end != std::string::npos) {
      std::string line = read_.substr(0, end);
      read_.erase(0, end + 1);
      return line;
    }
    looked_at = read_.size();
    if (looked_at > kMaxLineBytes)
      throw Error(ErrorCode::kLimit, "a started program printed a line of more than " +
                                         std::to_string(kMaxLineBytes) + " bytes");
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    pollfd ready{output_, POLLIN, 0};
    if (left.count() <= 0 || poll(&ready, 1, static_cast<int>(left.count())) <= 0) return {};
    const ssize_t more = read(output_, bytes.data(), bytes.size());
    if (more <= 0) return {};
    read_.append(bytes.data(), static_cast<size_t>(more));
  }
}

int ChildProcess::wait() {
  close(std::exchange(output_, -1));
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return exitStatus(status);
}

void ChildProcess::signal(int number) const noexcept {
  if (process_ > 0) kill(process_, number);
}

std::string ChildProcess::lastMessage() const {
  if (messages_ < 0) return {};
  const off_t size = lseek(messages_, 0, SEEK_END);
  std::string text(std::min(static_cast<size_t>(size), kMaxMessageBytes), '\0');
  const ssize_t got = pread(messages_, text.data(), text.size(), size - static_cast<off_t>(text.size()));
  text.resize(got > 0 ? static_cast<size_t>(got) : 0);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const size_t line = text.find_last_of('\n');
  return line == std::string::npos ? text : text.substr(line + 1);
}

std::string saidBy(const ChildProcess& server, const std::string& otherwise) {
  std::string said = server.lastMessage();
  constexpr std::string_view kPrefix = "lodestreamd: ";
  if (said.starts_with(kPrefix)) said.erase(0, kPrefix.size());
  return said.empty() ? otherwise : said;
}

std::filesystem::path siblingServer() {
  std::error_code failed;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", failed);
  const std::filesystem::path server = self.parent_path() / "lodestreamd";
  if (failed || access(server.c_str(), X_OK) != 0)
    throw Error(ErrorCode::kIo,
                "lodestreamd is not beside lodestream (" + server.string() +
                    "): install both into one folder, or serve the model and name lode://HOST/MODEL");
  return server;
}

}  // namespace lode::app
