#pragma once

#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>

namespace lode {

/// From now on SIGINT, SIGTERM and SIGHUP end the process with a line on stderr, after what is unfinished was
/// removed: but for those that are ignored, or that somebody else handles, then or later.
void endCleanlyWhenInterrupted() noexcept;

/// While it lives, this thread is not interrupted: in a program of one thread, what it makes meanwhile is
/// told of before. Where another thread takes the signal, Unfinished removes what comes too late.
class Uninterrupted {
 public:
  Uninterrupted() noexcept;
  ~Uninterrupted();
  Uninterrupted(const Uninterrupted&) = delete;
  Uninterrupted& operator=(const Uninterrupted&) = delete;

 private:
  sigset_t before_{};
};

/// A file or a folder that is not finished yet: if a signal ends the process while this lives, it is removed,
/// a folder with all that is in it. Calls endCleanlyWhenInterrupted(). Thread safe.
/// To be made under the same Uninterrupted as what it names, or before that is there.
class Unfinished {
 public:
  Unfinished() = default;  ///< nothing
  explicit Unfinished(const std::filesystem::path& path);
  ~Unfinished() { finish(); }
  Unfinished(Unfinished&& other) noexcept;
  Unfinished& operator=(Unfinished&& other) noexcept;

  /// It stays from now on.
  void finish() noexcept;

 private:
  std::unique_ptr<const std::string> path_;  ///< where it is, which the slot points to
  std::atomic<const char*>* slot_ = nullptr;
};

}  // namespace lode
