#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <utility>

#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>
#include <asio/post.hpp>
#include <linux/sockios.h>
#include <sys/ioctl.h>

#include "common/error.h"
#include "server/serve/net/connection.h"

/// The writing side of Connection: selects the next chunks and reads their bytes.
namespace lode::serve {

namespace {

constexpr size_t kChunkFrameHeadBytes = proto::kFrameHeaderBytes + proto::kBlobChunkHeaderBytes;
/// Largest number of unused buffers per thread; further buffers are freed.
constexpr size_t kMaxFreeBuffers = 64;
/// Largest number of reads from disk that a connection makes at a time.
constexpr size_t kMaxColdReads = 8;
constexpr size_t kSlowWriteBytes = 16u << 10;  ///< size of a write on a slow link
/// Size of the first writes of a connection. A write of this size fits the client's first TCP window, so that
/// a client that never reads does not occupy a buffer here. Writes become larger after kReadersBytes, because
/// these bytes show that the client reads.
constexpr size_t kFirstWriteBytes = 48u << 10, kReadersBytes = 256u << 10;
/// Largest number of unsent bytes in the kernel for a link that counts as fast.
constexpr int kLittleUnsentBytes = 8 << 10;
constexpr auto kLinger = std::chrono::seconds(2);
/// Time for the client to close a connection that ended for memory. The time is short, because other
/// connections wait for the memory.
constexpr auto kLingerForMemory = std::chrono::milliseconds(100);

void append(ChunkBuffer& buffer, const Chunk& chunk) {
  const auto head =
      proto::encodeFrameHeader({static_cast<uint32_t>(proto::kBlobChunkHeaderBytes + chunk.bytes),
                                static_cast<uint8_t>(proto::FrameType::kBlob), 0, chunk.call});
  const auto blob_head = proto::encodeBlobChunkHeader(chunk.header);
  std::byte* at = buffer.bytes.get() + buffer.used;
  std::memcpy(at, head.data(), head.size());
  std::memcpy(at + head.size(), blob_head.data(), blob_head.size());
  buffer.used += kChunkFrameHeadBytes + chunk.bytes;
}

BlobRange rangeOf(const Chunk& chunk) { return {chunk.blob, chunk.header.offset_bytes, chunk.bytes}; }

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

asio::awaitable<void> Connection::write() {
  try {
    co_await writeFrames();
    linger_until_ = Clock::now() + (end_ == EndReason::kMemory ? Clock::duration(kLingerForMemory) : kLinger);
    co_await stream_.bytes().finish();
    if (gone_) stream_.close();
  } catch (const std::exception&) {  // the connection broke, or memory ran out
    end(EndReason::kBroken);
    gone_ = true;
    stream_.close();
  }
  wakeReader();
}

asio::awaitable<void> Connection::writeFrames() {
  while (!gone_) {
    if (slow_) {  // wait for the kernel before the next chunk is chosen, so that urgent requests that arrive
                  // meanwhile go first
      writing_since_ = Clock::now();
      session_.onBackpressure(*writing_since_);
      asio::error_code error;
      co_await stream_.bytes().waitWritable(error);
      session_.onWritable(Clock::now());
      if (error) throw Error(ErrorCode::kNetwork, "the connection broke while writing: " + error.message());
    }
    while (holds_answer_) {
      writing_since_.reset();
      co_await sleep(to_write_, write_woken_);
    }
    const proto::Bytes control = session_.takeControl();
    ChunkBuffer buffer;
    if (isItsTurn()) {
      gather(buffer);
      endTurn(buffer.used);
    }
    const size_t bytes = control.size() + buffer.used;
    if (bytes > 0) {
      const std::array parts{asio::buffer(control), asio::const_buffer(buffer.bytes.get(), buffer.used)};
      writing_since_ = Clock::now();
      co_await stream_.write(parts);
      session_.controlSent(control.size());
      sent_bytes_ += bytes;
      slow_ = linkIsSlow();
    }
    writing_since_.reset();
    host_.buffers.give(std::move(buffer));
    if (bytes == 0 && session_.controlBytes() == 0) {
      if (session_.finished()) co_return;
      if (session_.waitsForWindow()) session_.onBackpressure(Clock::now());
      to_write_.expires_at(turn_.value_or(Clock::time_point::max()));
      co_await sleep(to_write_, write_woken_);
      session_.onWritable(Clock::now());
    }
    wakeReader();
  }
}

bool Connection::linkIsSlow() {
  int unsent = 0;
  return ioctl(stream_.bytes().socket().native_handle(), SIOCOUTQNSD, &unsent) == 0 &&
         unsent > kLittleUnsentBytes;
}

/// Returns true if the rates allow sending blobs now. Otherwise reserves a time for which the writer waits.
bool Connection::isItsTurn() {
  if (!rate_.limited() && !host_.rate->limited()) return true;
  const auto now = Clock::now();
  if (!turn_ && session_.wantsToSend())
    turn_ = std::max(rate_.take(kSlowWriteBytes, now), host_.rate->take(kSlowWriteBytes, now));
  return turn_ && *turn_ <= now;
}

void Connection::endTurn(size_t sent_bytes) {
  if (!turn_) return;
  rate_.give(kSlowWriteBytes - sent_bytes);
  host_.rate->give(kSlowWriteBytes - sent_bytes);
  turn_.reset();
}

void Connection::gather(ChunkBuffer& buffer) {
  const size_t of_fast_link = sent_bytes_ < kReadersBytes ? kFirstWriteBytes : ChunkBuffer::kBytes;
  const size_t most = slow_ || turn_ ? kSlowWriteBytes : of_fast_link;
  while (buffer.used + kChunkFrameHeadBytes + kMinChunkBytes <= most) {
    const size_t space = most - buffer.used - kChunkFrameHeadBytes;
    const std::optional<Chunk> chunk = session_.beginChunk(static_cast<uint32_t>(space));
    if (!chunk) return;
    if (!buffer.bytes) buffer = host_.buffers.take();
    const std::span into(buffer.bytes.get() + buffer.used + kChunkFrameHeadBytes, chunk->bytes);
    const ReadResult result = readChunk(*chunk, into);
    if (result == ReadResult::kCold) {
      if (!startFetching(*chunk)) return session_.abandonChunk();
      session_.parkChunk();
    } else if (result != ReadResult::kDone) {
      fail(*chunk, result);
    } else {
      noteRead(*chunk);
      session_.finishChunk();
      append(buffer, *chunk);
    }
  }
}

ReadResult Connection::readChunk(const Chunk& chunk, std::span<std::byte> into) {
  const auto cold = std::ranges::find_if(cold_, [&](const auto& c) {
    return c->chunk.serial == chunk.serial && c->result != ReadResult::kCold;
  });
  if (cold == cold_.end()) return chunk.opened->model->blobs->readHot(rangeOf(chunk), into);
  const std::shared_ptr<ColdRead> read = std::move(*cold);
  cold_.erase(cold);
  reading_.give(read->chunk.bytes);
  // The client's window or the size of a write may have shrunk during the read. Send the beginning, and read
  // the rest again later.
  if (read->result == ReadResult::kDone) {
    const size_t there = std::min(read->bytes.size(), into.size());
    std::memcpy(into.data(), read->bytes.data(), there);
    if (there < into.size()) return chunk.opened->model->blobs->readHot(rangeOf(chunk), into);
  }
  return read->result;
}

/// Makes room for a read of the most urgent request. Drops finished reads of less urgent requests. They wait
/// for the client's window, so that otherwise no event would resume the writer. @return false if there
/// is no room because all remaining reads are unfinished.
bool Connection::dropFinishedReads(uint32_t bytes) {
  while (cold_.size() >= kMaxColdReads || !reading_.tryTake(bytes)) {
    const auto finished = std::find_if(cold_.rbegin(), cold_.rend(),
                                       [](const auto& read) { return read->result != ReadResult::kCold; });
    if (finished == cold_.rend()) return false;
    reading_.give((*finished)->chunk.bytes);
    cold_.erase(std::next(finished).base());
  }
  return true;
}

bool Connection::startFetching(const Chunk& chunk) {
  if (!dropFinishedReads(chunk.bytes)) {
    if (!cold_.empty()) return false;
    reading_.take(chunk.bytes);  // charge one read even without room, so that the connection makes progress
  }
  auto cold = std::make_shared<ColdRead>(ColdRead{chunk, {}});
  cold_.push_back(cold);
  if (chunk.opened->counters != nullptr) chunk.opened->counters->cold_reads.add();
  host_.readers->read(chunk.opened->model->blobs, rangeOf(chunk),
                      [self = shared_from_this(), cold](ReadResult result, std::vector<std::byte>& bytes) {
                        // If an earlier call failed to post, it has already moved the bytes.
                        if (cold->bytes.empty()) cold->bytes = std::move(bytes);
                        asio::post(self->stream_.bytes().executor(), [self, cold, result] {
                          cold->result = result;
                          self->endFetching(cold);
                        });
                      });
  return true;
}

void Connection::endFetching(const std::shared_ptr<ColdRead>& cold) {
  if (!session_.unpark(cold->chunk) && std::erase(cold_, cold) > 0) reading_.give(cold->chunk.bytes);
  wakeWriter();
}

void Connection::fail(const Chunk& chunk, ReadResult result) {
  ModelCounters* const counters = chunk.opened->counters;
  const std::string blob = "blob " + std::to_string(chunk.blob);
  if (result == ReadResult::kDamaged) {
    if (counters != nullptr) counters->damaged.add();
    session_.failChunk(proto::WireError::kDamagedStore,
                       blob +
                           " of the store is damaged: copy the store again, or rebuild it; lodestreamd "
                           "verify lists the damage");
  } else if (result == ReadResult::kNoMemory) {
    session_.failChunk(proto::WireError::kNotReady,
                       "the server is short of memory to read " + blob + "; request it again later");
  } else {
    if (counters != nullptr) counters->unreadable.add();
    session_.failChunk(proto::WireError::kInternal,
                       blob +
                           " of the store cannot be read now, because the server's storage fails or does "
                           "not answer; request it again later");
  }
}

void Connection::noteRead(const Chunk& chunk) noexcept {
  const auto request_class = static_cast<size_t>(chunk.request_class);
  const auto now = Clock::now();
  if (chunk.first()) {
    const auto held = session_.heldSince(chunk, now);
    host_.counters->held[request_class].add(held);
    host_.counters->queue[request_class].add(now - chunk.asked - held);
  }
  if (chunk.last()) {
    ++blobs_;
    host_.counters->send[request_class].add(now - chunk.asked);
  }
  if (chunk.opened->counters == nullptr) return;
  chunk.opened->counters->bytes.add(chunk.bytes);
  if (chunk.last()) chunk.opened->counters->blobs.add();
}

}  // namespace lode::serve
