// Parses requests of HTTP and what their fields say. The result must not depend on the bytes after a head,
// nor on how much of it was searched before. A decoded path must survive encoding.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "common/printable.h"
#include "server/http/conditions.h"
#include "server/http/request_head.h"
#include "server/http/route.h"

namespace {

using namespace lode::http;

void require(bool condition) {
  if (!condition) std::abort();
}

void checkRoute(std::string_view target) {
  const Route route = parseTarget(target);
  require(lode::isPrintableUtf8(route.model) && lode::isPrintableUtf8(route.token.value_or("")));
  const bool is_file = route.resource == Resource::kTileset || route.resource == Resource::kTilesetPage ||
                       isBinary(route.resource);
  require(is_file || route.model.empty());
  if (route.resource == Resource::kPageFile) {
    const Route again = parseTarget("/" + percentEncode(route.file));
    require(again.resource == route.resource && again.file == route.file);
  } else {
    require(route.file.find("..") == std::string::npos);
  }
  if (!is_file) return;
  const std::string prefix = route.token ? "/t/" + percentEncode(*route.token) : "";
  const Route again = parseTarget(prefix + "/" + percentEncode(route.model) + "/" + route.file);
  require(again.resource == route.resource && again.model == route.model && again.file == route.file &&
          again.token == route.token);
}

void checkRange(std::string_view field, uint64_t total_bytes) {
  const ContentRange range = parseRange(field, total_bytes);
  require(range.bytes <= total_bytes && range.first <= total_bytes - range.bytes);
  require(range.kind != RangeKind::kPart || range.bytes > 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  checkRoute(text);
  checkRange(text, 1000);
  matchesAny(text, "\"a\"");
  acceptsGzip(text);
  isSameOrigin(text, "a:80");
  isLoopbackHost(text);
  const auto parsed = parseHead(text);
  require(parsed || size < kMaxHeadBytes);
  if (!parsed) return 0;
  require(parsed->bytes <= size);
  require((parsed->refused_with != 0) != parsed->why.empty());
  if (parsed->refused_with != 0) return 0;
  const std::string_view alone = text.substr(0, parsed->bytes);
  const auto again = parseHead(alone, parsed->bytes - 1);
  require(again && again->bytes == parsed->bytes && again->head.target == parsed->head.target);
  require(!parseHead(alone.substr(0, alone.size() - 1)));
  checkRoute(parsed->head.target);
  checkRange(parsed->head.range, 12345);
  return 0;
}
