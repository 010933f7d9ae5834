#pragma once

#include <cstddef>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "common/error.h"

namespace lode {

/// What `make` gives, which starts threads.
/// @param purpose  what they are for, for people: "to decode".
/// @throws Error kIo if the system gives none.
template <typename Make>
auto withThreads(const std::string& purpose, Make&& make) {
  try {
    return make();
  } catch (const std::system_error& refused) {
    throw Error(ErrorCode::kIo,
                "the system gives no thread " + purpose + " (" + refused.code().message() +
                    "): let the program have more memory or more threads (ulimit -v, ulimit -u)");
  }
}

/// A thread that does some work; the caller's to join. @throws Error as withThreads().
template <typename Thread = std::thread, typename Work>
Thread startThread(const std::string& purpose, Work&& work) {
  return withThreads(purpose, [&] { return Thread(std::forward<Work>(work)); });
}

/// Threads that share some work, as many of `count` as the system gives. @throws Error as withThreads().
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
