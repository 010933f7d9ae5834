// The server's operator new calls malloc(), and takes a block of the MemoryReserve if malloc() fails. A
// new-handler could not do this, because a new-handler does not know the requested size: a few large requests
// would empty the reserve.

#include <cstdlib>
#include <new>

#include "server/serve/memory/memory_reserve.h"

// NOLINTBEGIN(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)
namespace {

void* allocate(size_t bytes) noexcept {
  void* const memory = std::malloc(bytes == 0 ? 1 : bytes);
  return memory != nullptr ? memory : lode::serve::MemoryReserve::take(bytes);
}

}  // namespace

void* operator new(size_t bytes) {
  void* const memory = allocate(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void* operator new(size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
// NOLINTEND(cppcoreguidelines-no-malloc,cppcoreguidelines-owning-memory)
