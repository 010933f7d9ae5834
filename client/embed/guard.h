#pragma once

#include <exception>
#include <new>
#include <string>

#include "common/error.h"

namespace lode::embed {

/// Keeps a message for lodestream_last_error() on this thread.
void remember(const char* message) noexcept;

/// What a pointer of the caller's points to. @throws Error kUsage for NULL.
template <typename T>
T& given(T* pointer, const char* what, const char* remedy = "the address of one") {
  if (pointer == nullptr)
    throw Error(ErrorCode::kUsage, std::string("a NULL ") + what + " was given: give " + remedy);
  return *pointer;
}

/// Runs what a function of the C face does, from which nothing may be thrown. @return what that returns: 1,
/// or 0.
template <typename Work>
int guard(Work&& work) noexcept {
  try {
    work();
    return 1;
  } catch (const std::bad_alloc&) {
    remember(kOutOfMemory);
    return 0;
  } catch (const std::exception& error) {
    remember(error.what());
    return 0;
  }
}

}  // namespace lode::embed
