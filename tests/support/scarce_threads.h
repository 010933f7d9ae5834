#pragma once

#include <atomic>
#include <cerrno>
#include <climits>

#include <dlfcn.h>
#include <pthread.h>

/// A system that gives no more threads, for the one source of a test program that includes this.
namespace lode::test {

/// How many it still gives.
inline std::atomic<int> threads_left{INT_MAX};

}  // namespace lode::test

/// This program's own: the system's, but for threads_left.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) noexcept {
  if (lode::test::threads_left <= 0) return EAGAIN;
  --lode::test::threads_left;
  static const auto system = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return system(thread, attributes, start, argument);
}
