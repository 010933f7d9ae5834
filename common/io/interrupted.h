#pragma once

#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>

namespace lode {

/// Installs handlers for SIGINT, SIGTERM and SIGHUP: they remove every Unfinished, print a line on stderr and
/// end the process. Signals that are ignored or already have a handler keep their disposition.
void endCleanlyWhenInterrupted() noexcept;

/// Blocks these signals in the calling thread during its lifetime, so that a file and its Unfinished are
/// created together. If another thread takes the signal, the constructor of Unfinished removes the file.
class Uninterrupted {
 public:
  Uninterrupted() noexcept;
  ~Uninterrupted();
  Uninterrupted(const Uninterrupted&) = delete;
  Uninterrupted& operator=(const Uninterrupted&) = delete;

 private:
  sigset_t before_{};
};

/// Marks a file or a folder as unfinished: if a signal ends the process during its lifetime, the file or the
/// whole folder is removed. Calls endCleanlyWhenInterrupted(). Thread safe.
/// Create it before the file, or under the same Uninterrupted.
class Unfinished {
 public:
  Unfinished() = default;  ///< marks nothing
  explicit Unfinished(const std::filesystem::path& path);
  ~Unfinished() { finish(); }
  Unfinished(Unfinished&& other) noexcept;
  Unfinished& operator=(Unfinished&& other) noexcept;

  /// Keeps the file from now on.
  void finish() noexcept;

 private:
  std::unique_ptr<const std::string> path_;  ///< the slot points to this string
  std::atomic<const char*>* slot_ = nullptr;
};

}  // namespace lode
