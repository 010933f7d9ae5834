#include "common/io/interrupted.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include <dirent.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace lode {
namespace {

constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
constexpr size_t kMostUnfinished = 64;  // largest number of files and folders that a signal removes
constexpr int kMostTries = 100;         // attempts to remove a folder; other threads may add files meanwhile
constexpr int kDeepestFolder = 8;

std::array<std::atomic<const char*>, kMostUnfinished> unfinished;
std::atomic<bool> is_ending = false;

// The functions from here to endInterrupted() run in a signal handler. They make only system calls, allocate
// no memory and take no locks.

void removeFolder(int in, const char* name, int depth) noexcept;

void removeEntries(int folder, int depth) noexcept {
  alignas(dirent64) std::array<char, 4096> entries;
  while (true) {
    const long bytes = ::syscall(SYS_getdents64, folder, entries.data(), entries.size());
    if (bytes <= 0) return;
    for (long at = 0; at < bytes;) {
      const auto* const entry = reinterpret_cast<const dirent64*>(entries.data() + at);
      const char* const name = entry->d_name;
      at += entry->d_reclen;
      if (std::strcmp(name, ".") == 0 || std::strcmp(name, "..") == 0) continue;
      if (::unlinkat(folder, name, 0) != 0 && errno == EISDIR && depth < kDeepestFolder)
        removeFolder(folder, name, depth + 1);
    }
  }
}

void removeFolder(int in, const char* name, int depth) noexcept {
  for (int tries = 0; tries < kMostTries; ++tries) {
    const int folder = ::openat(in, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0) return;
    removeEntries(folder, depth);
    ::close(folder);
    if (::unlinkat(in, name, AT_REMOVEDIR) == 0 || errno != ENOTEMPTY) return;
  }
}

/// Removes a file or a folder. @return false if the path did not exist.
bool remove(const char* path) noexcept {
  if (::unlink(path) == 0) return true;
  if (errno != EISDIR) return false;
  removeFolder(AT_FDCWD, path, 0);
  return true;
}

/// Removes a file or a folder, then waits until the process ends. Another thread is ending the process; it
/// may have looked for the path before the path existed.
[[noreturn]] void removeAndWait(const char* path) noexcept {
  remove(path);
  while (true) ::pause();
}

void say(const char* text) noexcept {
  [[maybe_unused]] const ssize_t ignored = ::write(STDERR_FILENO, text, std::strlen(text));
}

void endBy(int signal) { endInterrupted(signal, nullptr); }

}  // namespace

void endInterrupted(int signal, const char* message) noexcept {
  is_ending = true;
  bool is_removed = false;
  for (const std::atomic<const char*>& slot : unfinished) {
    const char* const path = slot;
    if (path != nullptr && remove(path)) is_removed = true;
  }
  say(program_invocation_short_name);
  say(": ");
  say(message != nullptr ? message
      : is_removed       ? "interrupted; unfinished output is removed"
                         : "interrupted");
  say("\n");
  struct sigaction action {};
  action.sa_handler = SIG_DFL;
  ::sigaction(signal, &action, nullptr);
  sigset_t only{};
  sigaddset(&only, signal);
  ::pthread_sigmask(SIG_UNBLOCK, &only, nullptr);  // the signal is blocked while its handler runs
  ::raise(signal);
  ::_exit(128 + signal);
}

void endCleanlyWhenInterrupted() noexcept {
  struct sigaction action {};
  action.sa_handler = endBy;
  for (const int signal : kSignals) sigaddset(&action.sa_mask, signal);
  for (const int signal : kSignals) {
    struct sigaction now {};
    const bool is_free = ::sigaction(signal, nullptr, &now) == 0 && (now.sa_flags & SA_SIGINFO) == 0 &&
                         now.sa_handler == SIG_DFL;
    if (is_free) ::sigaction(signal, &action, nullptr);
  }
}

Uninterrupted::Uninterrupted() noexcept {
  sigset_t held{};
  for (const int signal : kSignals) sigaddset(&held, signal);
  ::pthread_sigmask(SIG_BLOCK, &held, &before_);
}

Uninterrupted::~Uninterrupted() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

Unfinished::Unfinished(const std::filesystem::path& path)
    : path_(std::make_unique<const std::string>(path.string())) {
  endCleanlyWhenInterrupted();
  for (std::atomic<const char*>& slot : unfinished) {
    const char* none = nullptr;
    if (!slot.compare_exchange_strong(none, path_->c_str())) continue;
    slot_ = &slot;
    if (is_ending) removeAndWait(path_->c_str());
    return;
  }
}

Unfinished::Unfinished(Unfinished&& other) noexcept
    : path_(std::move(other.path_)), slot_(std::exchange(other.slot_, nullptr)) {}

Unfinished& Unfinished::operator=(Unfinished&& other) noexcept {
  finish();
  path_ = std::move(other.path_);
  slot_ = std::exchange(other.slot_, nullptr);
  return *this;
}

void Unfinished::finish() noexcept {
  if (slot_ == nullptr) return;
  std::exchange(slot_, nullptr)->store(nullptr);
  while (is_ending) ::pause();  // waits, because the thread that ends the process may still read the path
  path_.reset();
}

}  // namespace lode
