#pragma once

#include <utility>

namespace lode {

/// Empties a container and frees what it holds: `container = {}` is an assignment of no items, which keeps
/// the room for those that were there.
template <typename Container>
void releaseStorage(Container& container) {
  Container empty;
  std::swap(container, empty);
}

}  // namespace lode
