// Decodes hierarchy pages. The first byte of the input selects the root page or the depth of the page's
// owner. A page that decodes must encode to the same bytes.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "common/codec/hierarchy_page.h"
#include "common/error.h"

namespace {

using namespace lode;

void require(bool condition) {
  if (!condition) std::abort();
}

NodeKey ownerAt(int depth) {
  NodeKey owner = kRootKey;
  while (owner.depth() < depth) owner = owner.child(static_cast<unsigned>(owner.depth()) % 8);
  return owner;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data + 1, size - 1));
  const int depth = data[0] % 10 * 2;  // owners of pages have even depths
  try {
    const HierarchyPage page = decodePage(bytes, ownerAt(depth), depth == 0);
    require(std::ranges::equal(encodePage(page), bytes));
  } catch (const Error& error) {
    require(std::strpbrk(error.what(), "\r\n") == nullptr);
  }
  return 0;
}
