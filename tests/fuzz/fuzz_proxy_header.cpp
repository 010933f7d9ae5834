// Parses the header that a balancer sends before a client's bytes. The result must not depend on the bytes
// after the header. A header that is cut short must count as incomplete.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "common/error.h"
#include "server/serve/net/proxy_header.h"

namespace {

using namespace lode::serve;

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  try {
    const auto header = parseProxyHeader(bytes);
    require(header || size < kMaxProxyHeaderBytes);
    if (!header) return 0;
    require(header->bytes > 0 && header->bytes <= size && header->bytes <= kMaxProxyHeaderBytes);
    const auto alone = parseProxyHeader(bytes.first(header->bytes));
    require(alone && alone->bytes == header->bytes && alone->client == header->client);
    require(!parseProxyHeader(bytes.first(header->bytes - 1)));
  } catch (const lode::Error& error) {
    require(std::strpbrk(error.what(), "\r\n") == nullptr);
  }
  return 0;
}
