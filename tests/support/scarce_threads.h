#pragma once

#include <atomic>
#include <cerrno>
#include <climits>

#include <dlfcn.h>
#include <pthread.h>

/// Imitates a system that refuses further threads. Only one source of a test program may include this header.
namespace lode::test {

/// Number of threads that the system still allows.
inline std::atomic<int> threads_left{INT_MAX};

}  // namespace lode::test

/// Replaces the system's function in this program. Obeys threads_left.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) noexcept {
  if (lode::test::threads_left <= 0) return EAGAIN;
  --lode::test::threads_left;
  static const auto system = reinterpret_cast<decltype(&pthread_create)>(dlsym(RTLD_NEXT, "pthread_create"));
  return system(thread, attributes, start, argument);
}
