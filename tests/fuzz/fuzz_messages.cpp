// Decodes message bodies from an untrusted peer. The first byte of the input is the frame's type. A message
// that decodes must stay the same after encoding and decoding again. Error messages must have one line.
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
    case FrameType::kBlob:
      return (void)decodeBlobChunk(body);
#define LODE_MESSAGE(number, name, type) \
  case FrameType::k##name:               \
    return check<type>(body);
      LODE_MESSAGES(LODE_MESSAGE)
#undef LODE_MESSAGE
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
