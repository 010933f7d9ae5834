#pragma once

#include <cstddef>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/error.h"

namespace lode {

/// Calls make(), which starts threads, and returns its result.
/// @param purpose  purpose of the threads for the error message, such as "to decode".
/// @throws Error kIo if the system refuses a thread.
template <typename Make>
auto withThreads(const std::string& purpose, Make&& make) {
  try {
    return make();
  } catch (const std::system_error& refused) {
    throw Error(ErrorCode::kIo,
                "the system cannot start a thread " + purpose + " (" + refused.code().message() +
                    "): let the program have more memory or more threads (ulimit -v, ulimit -u)");
  }
}

/// Starts a thread, which the caller joins. @throws Error as withThreads().
template <typename Thread = std::thread, typename Work>
Thread startThread(const std::string& purpose, Work&& work) {
  return withThreads(purpose, [&] { return Thread(std::forward<Work>(work)); });
}

/// Starts up to `count` threads that share work. Starts fewer if the system refuses some, but at least one.
/// @throws Error as withThreads().
template <typename Work>
std::vector<std::jthread> startThreads(size_t count, const std::string& purpose, const Work& work) {
  std::vector<std::jthread> threads;
  threads.reserve(count);
  while (threads.size() < count) {
    try {
      threads.push_back(startThread<std::jthread>(purpose, work));
    } catch (const Error&) {
      if (threads.empty()) throw;
      break;
    }
  }
  return threads;
}

}  // namespace lode
