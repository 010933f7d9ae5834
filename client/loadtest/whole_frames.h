#pragma once

#include <cstddef>
#include <span>

#include "proto/frame.h"

namespace lode::app {

/// Calls take(type, body) for each whole frame. @return the bytes that they took. @throws Error as
/// proto::decodeFrameHeader().
template <typename Take>
size_t forEachFrame(std::span<const std::byte> bytes, const Take& take) {
  size_t at = 0;
  while (bytes.size() - at >= proto::kFrameHeaderBytes) {
    const auto header = proto::decodeFrameHeader(bytes.subspan(at).first<proto::kFrameHeaderBytes>());
    const size_t whole = proto::kFrameHeaderBytes + header.body_bytes;
    if (bytes.size() - at < whole) break;
    take(static_cast<proto::FrameType>(header.type),
         bytes.subspan(at + proto::kFrameHeaderBytes, header.body_bytes));
    at += whole;
  }
  return at;
}

}  // namespace lode::app
