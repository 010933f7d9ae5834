#pragma once

#include <utility>

namespace lode {

/// Empties a container and frees its memory. `container = {}` assigns no items and keeps the capacity.
template <typename Container>
void releaseStorage(Container& container) {
  Container empty;
  std::swap(container, empty);
}

}  // namespace lode
