#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <thread>

namespace lode::test {

/// Returns the number of entries in a folder of /proc/self: "task" lists the threads of this process, "fd"
/// its descriptors.
inline size_t ownEntries(const char* folder) {
  const std::filesystem::directory_iterator entries(std::filesystem::path("/proc/self") / folder);
  return static_cast<size_t>(std::distance(begin(entries), end(entries)));
}

/// Waits until the folder has at most `count` entries. A joined thread is listed for another moment, and
/// another thread may take time to close its end of a connection.
/// @return number of entries then, or after five minutes.
inline size_t ownEntriesOnceDownTo(size_t count, const char* folder) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(300);
  while (true) {
    const size_t now = ownEntries(folder);
    if (now <= count || std::chrono::steady_clock::now() > deadline) return now;
    std::this_thread::yield();
  }
}

}  // namespace lode::test
