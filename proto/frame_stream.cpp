#include "proto/frame_stream.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include <asio/error.hpp>
#include <asio/read.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>
#include <asio/write.hpp>

#include "common/error.h"

namespace lode::proto {

namespace {

[[noreturn]] void lost(const char* doing, const asio::error_code& error) {
  throw Error(ErrorCode::kNetwork,
              std::string("the connection broke while ") + doing + ": " + error.message());
}

}  // namespace

FrameStream::FrameStream(asio::ip::tcp::socket socket, size_t read_ahead_bytes)
    : socket_(std::move(socket)), ahead_(std::max(read_ahead_bytes, kFrameHeaderBytes)) {}

asio::awaitable<bool> FrameStream::fill(size_t needed) {
  while (end_ - begin_ < needed) {
    std::memmove(ahead_.data(), ahead_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    asio::error_code error;
    end_ += co_await socket_.async_read_some(asio::buffer(ahead_.data() + end_, ahead_.size() - end_),
                                             asio::redirect_error(asio::use_awaitable, error));
    if (error == asio::error::eof && end_ == 0) co_return false;
    if (error) lost("reading a frame's header", error);
  }
  co_return true;
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
  frame.body.resize(frame.header.body_bytes);
  const size_t there = std::min(frame.body.size(), end_ - begin_);
  std::copy_n(ahead_.data() + begin_, there, frame.body.data());
  begin_ += there;
  if (there < frame.body.size()) {
    asio::error_code error;
    co_await asio::async_read(socket_, asio::buffer(frame.body.data() + there, frame.body.size() - there),
                              asio::redirect_error(asio::use_awaitable, error));
    if (error) lost("reading a frame's body", error);
  }
  co_return true;
}

asio::awaitable<void> FrameStream::write(std::span<const asio::const_buffer> parts) {
  asio::error_code error;
  co_await asio::async_write(socket_, parts, asio::redirect_error(asio::use_awaitable, error));
  if (error) lost("writing", error);
}

asio::awaitable<void> FrameStream::discard() {
  asio::error_code error;
  while (!error)
    co_await socket_.async_read_some(asio::buffer(ahead_), asio::redirect_error(asio::use_awaitable, error));
}

void FrameStream::close() noexcept {
  asio::error_code ignored;
  socket_.close(ignored);
}

}  // namespace lode::proto
