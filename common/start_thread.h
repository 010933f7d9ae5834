#pragma once

#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "common/error.h"

namespace lode {

/// A thread that does some work; the caller's to join. Several in a container: join those that there are
/// when one cannot be had.
/// @param purpose  what it is for, for people: "to decode".
/// @throws Error kIo if the system gives none.
template <typename Thread = std::thread, typename Work>
Thread startThread(const std::string& purpose, Work&& work) {
  try {
    return Thread(std::forward<Work>(work));
  } catch (const std::system_error& refused) {
    throw Error(ErrorCode::kIo,
                "the system gives no thread " + purpose + " (" + refused.code().message() +
                    "): let the program have more memory or more threads (ulimit -v, ulimit -u)");
  }
}

}  // namespace lode
