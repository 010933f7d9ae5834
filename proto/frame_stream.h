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

/// Frames on a byte stream. One coroutine may read while another writes, both on the stream's thread.
class FrameStream {
 public:
  /// A function that read() calls before a body grows by `more_bytes`. If the function returns false, the
  /// body does not grow, and read() throws Error kLimit.
  using Room = std::function<bool(size_t more_bytes)>;

  /// @param read_ahead_bytes  size of the read buffer; longer bodies are read directly into the frame.
  explicit FrameStream(ByteStream stream, size_t read_ahead_bytes = 4096, Room room = {});

  /// Reads one frame into `frame` and reuses the memory of `frame`. The memory of a body grows only as bytes
  /// arrive, even if the header announces a large length.
  /// @param max_body_bytes  limit; read() refuses a longer body before it allocates memory.
  /// @return false if the peer closed the connection between two frames.
  /// @throws Error kLimit, kProtocol (invalid header), kNetwork (closed within a frame, or reset).
  asio::awaitable<bool> read(Frame& frame, uint32_t max_body_bytes = kMaxFrameBodyBytes);

  /// Writes whole frames, gathered from several buffers. The buffers must stay valid until the awaitable
  /// completes.
  /// @throws Error kNetwork.
  asio::awaitable<void> write(std::span<const asio::const_buffer> parts);

  /// Reads and drops bytes until either side closes the connection. Closing a connection with unread bytes
  /// would reset it, and the peer could lose the last frames. Never throws.
  asio::awaitable<void> discard();

  ByteStream& bytes() noexcept { return stream_; }
  void close() noexcept { stream_.close(); }  ///< closes the stream; pending operations throw Error kNetwork

 private:
  asio::awaitable<bool> fill(size_t needed);
  asio::awaitable<void> readBody(std::vector<std::byte>& body, size_t announced);

  ByteStream stream_;
  Room room_;
  std::vector<std::byte> ahead_;
  size_t begin_ = 0, end_ = 0;  ///< range of the unread bytes in ahead_
};

}  // namespace lode::proto
