#pragma once

#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>

namespace lode {

/// Installs handlers for SIGINT, SIGTERM and SIGHUP. The handlers remove every file and folder that is marked
/// as Unfinished, print a line on stderr and end the process. A signal that is ignored or already has a
/// handler stays as it is.
void endCleanlyWhenInterrupted() noexcept;

/// Removes every file and folder that is marked as Unfinished, prints a message on stderr and ends the
/// process by the signal, as the sender of the signal expects. Does not wait for other threads. Any thread
/// and any signal handler can call the function.
/// @param message  text after the program's name, or nullptr for a text that says whether output was removed.
[[noreturn]] void endInterrupted(int signal, const char* message) noexcept;

/// Blocks SIGINT, SIGTERM and SIGHUP in the calling thread during this object's lifetime. Create a file and
/// its Unfinished while this object exists, so that no signal arrives between the two creations. If another
/// thread handles a signal meanwhile, the constructor of Unfinished removes the file.
class Uninterrupted {
 public:
  Uninterrupted() noexcept;
  ~Uninterrupted();
  Uninterrupted(const Uninterrupted&) = delete;
  Uninterrupted& operator=(const Uninterrupted&) = delete;

 private:
  sigset_t before_{};
};

/// Marks a file or a folder as unfinished. A signal that ends the process during this object's lifetime also
/// removes the file or the whole folder. Calls endCleanlyWhenInterrupted(). Thread safe. Create an Unfinished
/// before its file, or create both under the same Uninterrupted.
class Unfinished {
 public:
  Unfinished() = default;  ///< marks nothing
  explicit Unfinished(const std::filesystem::path& path);
  ~Unfinished() { finish(); }
  Unfinished(Unfinished&& other) noexcept;
  Unfinished& operator=(Unfinished&& other) noexcept;

  /// Removes the mark. From now on, signals leave the file or folder in place.
  void finish() noexcept;

 private:
  std::unique_ptr<const std::string> path_;  ///< the slot points to this string
  std::atomic<const char*>* slot_ = nullptr;
};

}  // namespace lode
