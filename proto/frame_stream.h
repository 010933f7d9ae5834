#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <asio/awaitable.hpp>
#include <asio/buffer.hpp>

#include "proto/byte_stream.h"
#include "proto/frame.h"
#include "proto/limits.h"

namespace lode::proto {

struct Frame {
  FrameHeader header;
  std::vector<std::byte> body;
};

/// Frames on a byte stream. One coroutine may read while another writes, all on the stream's one thread.
class FrameStream {
 public:
  /// Asked before a frame's body takes this many bytes more; refuses by false.
  using Room = std::function<bool(size_t more_bytes)>;

  /// @param read_ahead_bytes  how much is read in one go; bodies longer than it are read straight into place.
  explicit FrameStream(ByteStream stream, size_t read_ahead_bytes = 4096, Room room = {});

  /// Reads one frame; `frame` is reused from call to call, so that its memory is. A body takes memory as its
  /// bytes come, whatever its header announces.
  /// @param max_body_bytes  bodies announced longer are refused before any memory is taken.
  /// @return false if the peer closed the connection between two frames.
  /// @throws Error kLimit, kProtocol (a header that cannot be), kNetwork (gone in the middle of a frame,
  /// reset).
  asio::awaitable<bool> read(Frame& frame, uint32_t max_body_bytes = kMaxFrameBodyBytes);

  /// Writes whole frames from several places in one call of the system, nothing copied: control frames from
  /// one, a chunk's headers and bytes from another. Parts and bytes must stay until it is done.
  /// @throws Error kNetwork.
  asio::awaitable<void> write(std::span<const asio::const_buffer> parts);

  /// Reads and drops until the peer closes or the stream is closed here: a connection closed with bytes
  /// unread is reset, and the peer may lose what was sent last. Never throws.
  asio::awaitable<void> discard();

  ByteStream& bytes() noexcept { return stream_; }
  void close() noexcept { stream_.close(); }  ///< whatever is under way ends with Error kNetwork

 private:
  asio::awaitable<bool> fill(size_t needed);
  asio::awaitable<void> readBody(std::vector<std::byte>& body, size_t announced);

  ByteStream stream_;
  Room room_;
  std::vector<std::byte> ahead_;
  size_t begin_ = 0, end_ = 0;  ///< of what is in ahead_ and not yet given out
};

}  // namespace lode::proto
