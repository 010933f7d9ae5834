#pragma once

#include <utility>

namespace lode {

/// Empties a container and frees its memory. Unlike this function, `container = {}` may keep the capacity.
template <typename Container>
void releaseStorage(Container& container) {
  Container empty;
  std::swap(container, empty);
}

}  // namespace lode
