#include "programs.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace lode::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kCannotStart = 127;

/// Runs a program in the forked child. Makes only calls that are safe between fork and exec.
[[noreturn]] void become(const std::vector<char*>& arguments, const std::vector<char*>& environment, int out,
                         int err) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  for (char* variable : environment) putenv(variable);
  execvp(arguments[0], arguments.data());
  _exit(kCannotStart);
}

std::vector<char*> pointersTo(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  return pointers;
}

/// Waits for input. @return false if there is nothing to read until the deadline.
bool waitToRead(int file, Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
  pollfd ready{file, POLLIN, 0};
  return left.count() > 0 && poll(&ready, 1, static_cast<int>(left.count())) > 0;
}

std::string readAllOf(int file) {
  std::string text(static_cast<size_t>(lseek(file, 0, SEEK_END)), '\0');
  const ssize_t got = pread(file, text.data(), text.size(), 0);
  text.resize(got > 0 ? static_cast<size_t>(got) : 0);
  return text;
}

}  // namespace

void writeBytes(const fs::path& file, std::string_view bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  EXPECT_TRUE(out) << file;
}

Program::Program(const std::string& name, const std::vector<std::string>& arguments,
                 const std::vector<std::string>& environment) {
  const fs::path built = fs::path(LODE_BIN_DIR) / "bin" / name;
  std::vector<std::string> texts{fs::exists(built) ? built.string() : name};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> argument_pointers = pointersTo(texts);
  argument_pointers.push_back(nullptr);
  std::vector<std::string> variables = environment;
  const std::vector<char*> variable_pointers = pointersTo(variables);

  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) std::abort();
  err_ = memfd_create("stderr", MFD_CLOEXEC);
  process_ = fork();
  if (process_ == 0) become(argument_pointers, variable_pointers, ends[1], err_);
  if (process_ < 0 || err_ < 0) std::abort();
  close(ends[1]);
  out_ = ends[0];
  handle_ = static_cast<int>(syscall(SYS_pidfd_open, process_, 0));
}

Program::~Program() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  for (const int file : {handle_, out_, err_}) close(file);
}

std::string Program::readLine() {
  const auto deadline = Clock::now() + kPatience;
  std::string line;
  for (char next = 0; waitToRead(out_, deadline) && read(out_, &next, 1) == 1;) {
    line += next;
    if (next == '\n') break;
  }
  return line;
}

void Program::signal(int number) const { kill(process_, number); }

Outcome Program::wait() {
  const auto deadline = Clock::now() + kPatience;
  Outcome outcome;
  std::array<char, 4096> buffer{};
  bool in_time = false;
  while ((in_time = waitToRead(out_, deadline))) {
    const ssize_t got = read(out_, buffer.data(), buffer.size());
    if (got <= 0) break;
    outcome.out.append(buffer.data(), static_cast<size_t>(got));
  }
  if (!in_time || !waitToRead(handle_, deadline)) {
    ADD_FAILURE() << "a program hangs";
    kill(process_, SIGKILL);
  }
  int status = 0;
  waitpid(process_, &status, 0);
  process_ = -1;
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.err = readAllOf(err_);
  return outcome;
}

Outcome lodestreamd(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  return Program("lodestreamd", arguments, environment).wait();
}

Outcome lodestream(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  const WorkFolder cache;  // tests do not use the cache of the user
  std::vector<std::string> whole{"XDG_CACHE_HOME=" + cache.path().string()};
  whole.insert(whole.end(), environment.begin(), environment.end());
  return Program("lodestream", arguments, whole).wait();
}

namespace {

std::vector<std::string> serveArguments(const std::vector<fs::path>& stores,
                                        const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"serve", "--listen", "127.0.0.1:0"};
  for (const fs::path& store : stores) arguments.push_back(store);
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

}  // namespace

RunningServer::RunningServer(const std::vector<fs::path>& stores, const std::vector<std::string>& more)
    : program_("lodestreamd", serveArguments(stores, more)) {
  const auto ready = nlohmann::json::parse(program_.readLine(), nullptr, false);
  if (ready.is_object()) address_ = ready.value("listen", "");
  EXPECT_NE(address_, "") << "no line of a ready server";
}

std::string RunningServer::url(std::string_view model) const {
  return "lode://" + address_ + (model.empty() ? "" : "/") + std::string(model);
}

Outcome RunningServer::stop() {
  program_.signal(SIGTERM);
  return program_.wait();
}

void RunningServer::kill() {
  program_.signal(SIGKILL);
  program_.wait();
}

fs::path waitForFile(const fs::path& folder, std::string_view ending) {
  for (const auto deadline = Clock::now() + kPatience; Clock::now() < deadline; std::this_thread::yield()) {
    std::error_code gone;
    fs::recursive_directory_iterator at(folder, gone);
    for (const fs::recursive_directory_iterator end; !gone && at != end; at.increment(gone))
      if (at->path().string().ends_with(ending)) return at->path();
  }
  ADD_FAILURE() << "no file in " << folder << " came to end with " << ending;
  return {};
}

Processes processesNaming(std::string_view text) {
  Processes found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "cmdline", std::ios::binary);
    std::string line{std::istreambuf_iterator<char>(file), {}};
    std::replace(line.begin(), line.end(), '\0', ' ');
    if (line.find(text) != std::string::npos) found.emplace(std::stoi(entry.path().filename()), line);
  }
  return found;
}

void expectOneLine(const std::string& text) {
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  EXPECT_TRUE(text.ends_with('\n')) << text;
}

void expectFailure(const Outcome& outcome, const std::vector<std::string>& named) {
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  expectOneLine(outcome.err);
  for (const std::string& name : named)
    EXPECT_NE(outcome.err.find(name), std::string::npos) << "no '" << name << "' in: " << outcome.err;
}

fs::path makeSmallStore(const WorkFolder& folder) {
  const fs::path ply = folder / "small.ply", store = folder / "small.lode";
  EXPECT_EQ(
      lodestreamd({"sample", "asteroid", "--triangles", "4000", "--attributes", "normal,color", "-o", ply})
          .status,
      0);
  EXPECT_EQ(lodestreamd({"build", ply, "-o", store, "--triangles-per-node", "256", "--quiet"}).status, 0);
  return store;
}

}  // namespace lode::test
