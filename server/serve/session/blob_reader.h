#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>

#include <sys/stat.h>

#include "server/store/reader.h"

namespace lode::serve {

/// How a read went.
enum class ReadResult {
  kDone,
  kCold,     ///< not in the page cache, or too large to check at once: readCold() may wait for the disk
  kDamaged,  ///< the blob's checksum does not match, or the file is shorter than it was
  kFailed,   ///< the operating system refused
};

struct BlobRange {
  uint32_t blob = 0;
  uint32_t offset_bytes = 0;
  uint32_t bytes = 0;
};

struct BlobReaderOptions {
  /// How often the file is looked at for changes. A changed one has all its blobs checked again.
  std::chrono::nanoseconds look_every = std::chrono::milliseconds(20);
  /// After this a blob that was damaged is tried again: somebody may have copied it anew.
  std::chrono::seconds retry_damaged{10};
  /// One line for the operator, from any thread: once for each blob that becomes bad, once each time
  /// that the file was written to.
  std::function<void(std::string_view)> report = [](std::string_view) {};
};

/// Reads blobs of one store for the connections. A blob's checksum is compared when it is first read, and
/// again after the file has changed. Thread safe.
class BlobReader {
 public:
  BlobReader(store::Reader reader, BlobReaderOptions options);

  /// Reads without ever waiting for the disk. @param into  range.bytes long.
  ReadResult readHot(const BlobRange& range, std::span<std::byte> into) const noexcept;
  /// Reads, waiting if it must; of a blob that is not checked yet all of it.
  ReadResult readCold(const BlobRange& range, std::span<std::byte> into) const noexcept;

  const store::Reader& store() const noexcept { return reader_; }
  /// Whether the file at that path is the one that is open here, unchanged since.
  bool isStill(const struct stat& file) const noexcept;
  /// Reads that found a damaged blob, so far.
  uint64_t damagedReads() const noexcept { return damaged_reads_.load(std::memory_order_relaxed); }

 private:
  enum class Trust : uint32_t { kUnchecked, kGood, kDamaged };
  /// What makes a file another one.
  struct Look {
    uint64_t device = 0, inode = 0, bytes = 0;
    int64_t changed_ns = 0, modified_ns = 0;
    explicit Look(const struct stat& file) noexcept;
    bool operator==(const Look&) const = default;
  };

  Trust trustIn(uint32_t blob, uint32_t generation) const noexcept;
  void note(uint32_t blob, uint32_t generation, Trust trust) const noexcept;
  uint32_t lookAtFile() const noexcept;
  void lookNow() const noexcept;
  ReadResult checkHot(const BlobRange& range, std::span<std::byte> into, uint32_t generation) const noexcept;
  ReadResult bad(const BlobRange& range, uint32_t generation, std::string_view why) const noexcept;
  ReadResult failed(const BlobRange& range, std::string_view why) const noexcept;
  void report(const BlobRange& range, std::string_view why) const noexcept;

  store::Reader reader_;
  BlobReaderOptions options_;
  int hot_flags_;  ///< of preadv2: none where all of the file is in memory
  std::unique_ptr<std::atomic<uint32_t>[]> notes_;
  mutable std::atomic<uint32_t> generation_{0};  ///< of the file's contents
  mutable std::atomic<int64_t> looked_ns_{0};
  mutable std::mutex look_mutex_;
  mutable Look look_;  ///< behind the mutex
  mutable std::atomic<uint64_t> damaged_reads_{0};
};

}  // namespace lode::serve
