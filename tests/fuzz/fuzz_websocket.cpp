// Decodes the frames of a WebSocket's client. The result must not depend on how the bytes arrive.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "common/error.h"
#include "proto/websocket.h"

namespace {

using namespace lode::proto;

struct Decoded {
  std::vector<std::byte> payload, answers;
  bool is_refused = false, is_closed = false;

  bool operator==(const Decoded&) const = default;
};

Decoded decode(std::vector<std::byte> bytes, size_t piece_bytes) {
  Decoded decoded;
  WebSocketDecoder decoder;
  try {
    for (size_t at = 0; at < bytes.size(); at += piece_bytes) {
      const auto piece = std::span(bytes).subspan(at, std::min(piece_bytes, bytes.size() - at));
      const size_t count = decoder.decode(piece);
      if (count > piece.size()) std::abort();
      decoded.payload.insert(decoded.payload.end(), piece.begin(),
                             piece.begin() + static_cast<std::ptrdiff_t>(count));
    }
  } catch (const lode::Error&) {
    decoded.is_refused = true;
    decoded.payload.clear();  // pieces may show more or less of the payload before the mistake
    if (decoder.decode(bytes) != 0) std::abort();
  }
  decoded.answers = decoder.takeAnswers();
  decoded.is_closed = decoder.closed();
  return decoded;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto* const first = reinterpret_cast<const std::byte*>(data);
  const std::vector<std::byte> bytes(first, first + size);
  const Decoded whole = decode(bytes, std::max<size_t>(size, 1));
  for (const size_t piece_bytes : {1, 3, 64})
    if (decode(bytes, piece_bytes) != whole) std::abort();
  const std::string key(bytes.size() < 100 ? bytes.size() : 100, 'k');
  if (webSocketAccept(key).size() != 28) std::abort();
  isWebSocketKey({reinterpret_cast<const char*>(data), size});
  return 0;
}
