#include "server/serve/connection.h"

#include <array>
#include <cstring>
#include <utility>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/redirect_error.hpp>
#include <asio/use_awaitable.hpp>

#include "common/error.h"

namespace lode::serve {

namespace {

constexpr size_t kChunkFrameHeadBytes = proto::kFrameHeaderBytes + proto::kBlobChunkHeaderBytes;
constexpr size_t kMaxFreeBuffers = 64;          ///< of a thread; more are given back to the system
constexpr size_t kMaxKeptBodyBytes = 4u << 10;  ///< of the last frame, kept for the next
constexpr auto kLinger = std::chrono::seconds(2);

void append(ChunkBuffer& buffer, const Chunk& chunk) {
  const auto head =
      proto::encodeFrameHeader({static_cast<uint32_t>(proto::kBlobChunkHeaderBytes + chunk.bytes),
                                static_cast<uint8_t>(proto::FrameType::kBlob), 0, chunk.request});
  const auto blob_head = proto::encodeBlobChunkHeader(chunk.header);
  std::byte* at = buffer.bytes.get() + buffer.used;
  std::memcpy(at, head.data(), head.size());
  std::memcpy(at + head.size(), blob_head.data(), blob_head.size());
  buffer.used += kChunkFrameHeadBytes + chunk.bytes;
}

asio::awaitable<ReadResult> readOnPool(const ModelSet& models, Chunk chunk, std::span<std::byte> into) {
  co_return models.readCold(chunk, into);
}

}  // namespace

ChunkBuffer BufferPool::take() {
  if (free_.empty()) return {std::make_unique_for_overwrite<std::byte[]>(ChunkBuffer::kBytes), 0};
  ChunkBuffer buffer = std::move(free_.back());
  free_.pop_back();
  buffer.used = 0;
  return buffer;
}

void BufferPool::give(ChunkBuffer buffer) {
  if (buffer.bytes && free_.size() < kMaxFreeBuffers) free_.push_back(std::move(buffer));
}

Connection::Connection(asio::ip::tcp::socket socket, ConnectionHost host, SessionLimits limits)
    : stream_(std::move(socket), 2048),
      host_(host),
      session_(host.models->offered(), limits, Clock::now()),
      to_write_(stream_.socket().get_executor(), asio::steady_timer::time_point::max()),
      to_read_(stream_.socket().get_executor(), asio::steady_timer::time_point::max()) {}

void Connection::start() {
  const auto executor = stream_.socket().get_executor();
  asio::co_spawn(
      executor, [self = shared_from_this()] { return self->read(); }, asio::detached);
  asio::co_spawn(
      executor, [self = shared_from_this()] { return self->write(); }, asio::detached);
}

void Connection::startRefusing(proto::WireError code, const std::string& why) {
  session_.refuse(code, why);
  start();
}

void Connection::drain(const std::string& reason) {
  session_.drain(reason);
  wakeWriter();
}

void Connection::sweep(Clock::time_point now) {
  if (now >= session_.deadline() || (linger_until_ && now >= *linger_until_)) close();
}

void Connection::wakeWriter() {
  write_woken_ = true;
  to_write_.cancel();
}

void Connection::wakeReader() {
  read_woken_ = true;
  to_read_.cancel();
}

asio::awaitable<void> Connection::sleep(asio::steady_timer& until, bool& woken) {
  asio::error_code cancelled;
  if (!woken) co_await until.async_wait(asio::redirect_error(asio::use_awaitable, cancelled));
  woken = false;
}

asio::awaitable<void> Connection::read() {
  bool broken = false;
  try {
    co_await readFrames();
  } catch (const Error& error) {
    broken = error.code() == ErrorCode::kNetwork;
    if (!broken)
      session_.refuse(
          error.code() == ErrorCode::kLimit ? proto::WireError::kLimit : proto::WireError::kMalformed,
          error.what());
  } catch (const std::exception&) {  // out of memory: this connection is given up, the others go on
    broken = true;
  }
  if (session_.closing() && !broken) {
    wakeWriter();  // the Error goes out; what the client still sends is dropped
    co_await stream_.discard();
  } else {
    close();
  }
  gone_ = true;
  wakeWriter();
}

asio::awaitable<void> Connection::readFrames() {
  proto::Frame frame;
  while (!session_.closing()) {
    while (session_.controlBytes() > kMaxQueuedControlBytes && !gone_) co_await sleep(to_read_, read_woken_);
    if (gone_) co_return;
    const uint32_t limit = session_.greeted() ? proto::kMaxFrameBodyBytes : proto::kMaxHelloBodyBytes;
    const bool more = co_await stream_.read(frame, limit);
    if (!more) co_return;
    if (linger_until_) continue;
    session_.receive(frame.header, frame.body, Clock::now());
    if (frame.body.capacity() > kMaxKeptBodyBytes) frame.body = {};
    wakeWriter();
  }
}

asio::awaitable<void> Connection::write() {
  try {
    co_await writeFrames();
    linger_until_ = Clock::now() + kLinger;
    asio::error_code ignored;
    stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    if (gone_) close();
  } catch (const std::exception&) {  // the connection broke, or there is no memory for it
    gone_ = true;
    close();
  }
  wakeReader();
}

asio::awaitable<void> Connection::writeFrames() {
  while (!gone_) {
    const proto::Bytes control = session_.takeControl();
    ChunkBuffer buffer;
    co_await gather(buffer, control.empty());
    if (!control.empty() || buffer.used > 0) {
      const std::array parts{asio::buffer(control), asio::const_buffer(buffer.bytes.get(), buffer.used)};
      co_await stream_.write(parts);
    }
    const bool idle = control.empty() && buffer.used == 0 && session_.controlBytes() == 0;
    host_.buffers->give(std::move(buffer));
    if (idle && session_.finished()) co_return;
    wakeReader();
    if (idle) co_await sleep(to_write_, write_woken_);
  }
}

asio::awaitable<void> Connection::gather(ChunkBuffer& buffer, bool may_wait) {
  while (buffer.used < proto::kMaxChunkBytes) {
    const size_t space = ChunkBuffer::kBytes - buffer.used - kChunkFrameHeadBytes;
    const std::optional<Chunk> chunk = session_.beginChunk(static_cast<uint32_t>(space));
    if (!chunk) co_return;
    if (!buffer.bytes) buffer = host_.buffers->take();
    const std::span into(buffer.bytes.get() + buffer.used + kChunkFrameHeadBytes, chunk->bytes);
    ReadResult result = host_.models->readHot(*chunk, into);
    if (result == ReadResult::kCold && (!may_wait || buffer.used > 0)) {
      session_.abandonChunk();  // what is ready goes out before the disk is waited for
      co_return;
    }
    if (result == ReadResult::kCold)
      result = co_await asio::co_spawn(*host_.readers, readOnPool(*host_.models, *chunk, into),
                                       asio::use_awaitable);
    if (result == ReadResult::kDamaged) {
      session_.failChunk(proto::WireError::kDamagedStore,
                         "blob " + std::to_string(chunk->blob) +
                             " of the store is damaged; the server's operator should run lodestreamd verify");
    } else if (result == ReadResult::kFailed) {
      session_.failChunk(proto::WireError::kInternal, "the server could not read blob " +
                                                          std::to_string(chunk->blob) + "; try again later");
    } else if (session_.finishChunk()) {
      append(buffer, *chunk);
    }
  }
}

}  // namespace lode::serve
