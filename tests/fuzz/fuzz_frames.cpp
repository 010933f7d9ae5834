// Feeds the bytes of a hostile server to a client's session, which has requested some blobs. The first byte
// of the input determines where the bytes are cut. A frame header that decodes must encode to the same bytes.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <variant>
#include <vector>

#include "client/core/session/session.h"
#include "common/codec/hierarchy_page.h"
#include "common/error.h"
#include "proto/frame.h"

namespace {

using namespace lode;

void require(bool condition) {
  if (!condition) std::abort();
}

void checkHeader(std::span<const std::byte> bytes) {
  if (bytes.size() < proto::kFrameHeaderBytes) return;
  try {
    const auto head = bytes.first<proto::kFrameHeaderBytes>();
    require(std::ranges::equal(proto::encodeFrameHeader(proto::decodeFrameHeader(head)), head));
  } catch (const Error&) {
  }
}

/// Returns requests for a few small blobs. The blob numbers are those of the corpus, so that the input can
/// contain chunks and refusals of these requests.
std::vector<core::Request> fewRequests() {
  std::vector<core::Request> requests;
  for (uint32_t number = 2; number < 8; ++number)
    requests.push_back({{number, 40 * number, {}}, {}, proto::RequestClass::kVisible, 1.0f});
  return requests;
}

void take(core::Session& session) {
  while (const auto event = session.nextEvent()) {
    if (const auto* opened = std::get_if<core::ModelOpened>(&*event)) {
      if (opened->summary.root_page) session.expectUnasked(opened->summary.root_page, {});
      session.setRequests(fewRequests());
    }
    if (const auto* arrived = std::get_if<core::BlobArrived>(&*event))
      require(digestOf(arrived->bytes) == arrived->blob.digest &&
              arrived->bytes.size() == arrived->blob.bytes);
  }
}

void converse(std::span<const std::byte> bytes, size_t piece) {
  core::SessionOptions options;
  options.model = "m";
  const core::TimePoint now{std::chrono::seconds(1000)};
  core::Session session(options, now);
  try {
    session.takeOutgoing();
    for (size_t at = 0; at < bytes.size(); at += piece) {
      session.receive(bytes.subspan(at, std::min(piece, bytes.size() - at)), now);
      take(session);
      session.takeOutgoing();
    }
  } catch (const Error& error) {
    require(std::strpbrk(error.what(), "\r\n") == nullptr);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data + 1, size - 1));
  checkHeader(bytes);
  converse(bytes, data[0] == 0 ? bytes.size() + 1 : data[0]);
  return 0;
}
