#include "proto/frame_stream.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include <asio/error.hpp>

#include "common/error.h"

namespace lode::proto {

namespace {

constexpr size_t kFirstBodyBytes = 4096;  ///< memory allocated for a body before its first byte arrives

[[noreturn]] void lost(const char* doing, const asio::error_code& error) {
  throw Error(ErrorCode::kNetwork,
              std::string("the connection broke while ") + doing + ": " + error.message());
}

}  // namespace

FrameStream::FrameStream(ByteStream stream, size_t read_ahead_bytes, Room room)
    : stream_(std::move(stream)),
      room_(std::move(room)),
      ahead_(std::max(read_ahead_bytes, kFrameHeaderBytes)) {}

asio::awaitable<bool> FrameStream::fill(size_t needed) {
  while (end_ - begin_ < needed) {
    std::memmove(ahead_.data(), ahead_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    asio::error_code error;
    end_ += co_await stream_.readSome(asio::buffer(ahead_.data() + end_, ahead_.size() - end_), error);
    if (error == asio::error::eof && end_ == 0) co_return false;
    if (error) lost("reading a frame's header", error);
  }
  co_return true;
}

asio::awaitable<void> FrameStream::readBody(std::vector<std::byte>& body, size_t announced) {
  size_t have = std::min(announced, end_ - begin_);
  body.clear();
  body.reserve(std::min(announced, std::max(have, kFirstBodyBytes)));
  body.insert(body.end(), ahead_.data() + begin_, ahead_.data() + begin_ + have);
  begin_ += have;
  while (have < announced) {
    if (have == body.capacity()) {
      const size_t capacity = std::min(announced, 2 * body.capacity());
      if (room_ && !room_(capacity - have))
        throw Error(ErrorCode::kLimit, "there is no memory for a frame of " + std::to_string(announced) +
                                           " bytes now; send less at a time");
      body.reserve(capacity);
    }
    body.resize(std::min(announced, body.capacity()));
    asio::error_code error;
    have += co_await stream_.readSome(asio::buffer(body.data() + have, body.size() - have), error);
    if (error) lost("reading a frame's body", error);
    body.resize(have);
  }
}

asio::awaitable<bool> FrameStream::read(Frame& frame, uint32_t max_body_bytes) {
  const bool more = co_await fill(kFrameHeaderBytes);
  if (!more) co_return false;
  frame.header = decodeFrameHeader(
      std::span<const std::byte, kFrameHeaderBytes>(ahead_.data() + begin_, kFrameHeaderBytes));
  if (frame.header.body_bytes > max_body_bytes)
    throw Error(ErrorCode::kLimit, "a frame announces a body of " + std::to_string(frame.header.body_bytes) +
                                       " bytes; at this point the limit is " +
                                       std::to_string(max_body_bytes));
  begin_ += kFrameHeaderBytes;
  if (frame.header.body_bytes <= end_ - begin_) {
    frame.body.assign(ahead_.data() + begin_, ahead_.data() + begin_ + frame.header.body_bytes);
    begin_ += frame.header.body_bytes;
  } else {
    co_await readBody(frame.body, frame.header.body_bytes);
  }
  co_return true;
}

asio::awaitable<void> FrameStream::write(std::span<const asio::const_buffer> parts) {
  asio::error_code error;
  co_await stream_.write(parts, error);
  if (error) lost("writing", error);
}

asio::awaitable<void> FrameStream::discard() {
  asio::error_code error;
  try {
    while (!error) co_await stream_.readSome(asio::buffer(ahead_), error);
  } catch (const std::exception&) {  // the client breaks the rules of WebSocket again, or memory ran out
  }
}

}  // namespace lode::proto
