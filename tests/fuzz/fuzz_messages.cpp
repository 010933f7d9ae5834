// Bodies of every message from an untrusted peer: the first byte is the frame's type. What decodes must come
// back the same from its own encoding, and be text where it is text.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

#include "common/error.h"
#include "proto/frame.h"
#include "proto/messages.h"

namespace {

using namespace lode::proto;

void require(bool condition) {
  if (!condition) std::abort();
}

template <typename Message>
void check(std::span<const std::byte> body) {
  const auto message = decode<Message>(body);
  const Bytes frame = encode(message, 1);
  require(decode<Message>(std::span(frame).subspan(kFrameHeaderBytes)) == message);
}

void checkTyped(uint8_t type, std::span<const std::byte> body) {
  switch (static_cast<FrameType>(type)) {
    case FrameType::kHello:
      return check<Hello>(body);
    case FrameType::kWelcome:
      return check<Welcome>(body);
    case FrameType::kList:
      return check<List>(body);
    case FrameType::kModels:
      return check<Models>(body);
    case FrameType::kOpen:
      return check<Open>(body);
    case FrameType::kOpened:
      return check<Opened>(body);
    case FrameType::kRequests:
      return check<Requests>(body);
    case FrameType::kCredit:
      return check<Credit>(body);
    case FrameType::kBlob:
      return (void)decodeBlobChunk(body);
    case FrameType::kCancelled:
      return check<Cancelled>(body);
    case FrameType::kError:
      return check<ErrorMessage>(body);
    case FrameType::kGoAway:
      return check<GoAway>(body);
    case FrameType::kModelReplaced:
      return check<ModelReplaced>(body);
    case FrameType::kPing:
      return check<Ping>(body);
    case FrameType::kPong:
      return check<Pong>(body);
    case FrameType::kClose:
      return check<Close>(body);
    case FrameType::kClosed:
      return check<Closed>(body);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  try {
    checkTyped(data[0] % 18, std::as_bytes(std::span(data + 1, size - 1)));
  } catch (const lode::Error& error) {
    require(std::strpbrk(error.what(), "\r\n") == nullptr);
  }
  return 0;
}
