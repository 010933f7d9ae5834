#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <thread>

namespace lode::test {

/// Entries of a folder of /proc/self: "task" has the threads of this process, "fd" its descriptors.
inline size_t ownEntries(const char* folder) {
  const std::filesystem::directory_iterator entries(std::filesystem::path("/proc/self") / folder);
  return static_cast<size_t>(std::distance(begin(entries), end(entries)));
}

/// Waits until there are no more than so many: a thread that was joined is among them for a moment yet, and
/// another thread's end of a connection closes in its time.
/// @return how many there are then, or after five minutes.
inline size_t ownEntriesOnceDownTo(size_t count, const char* folder) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(300);
  while (true) {
    const size_t now = ownEntries(folder);
    if (now <= count || std::chrono::steady_clock::now() > deadline) return now;
    std::this_thread::yield();
  }
}

}  // namespace lode::test
