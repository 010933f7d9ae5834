#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>

#include <sys/stat.h>

#include "common/io/file_io.h"
#include "server/store/reader.h"

namespace lode::serve {

/// Result of a read.
enum class ReadResult {
  kDone,
  kCold,     ///< the blob is not in the page cache, or is too large to verify quickly; call readCold()
  kDamaged,  ///< the blob's checksum does not match, or the file was truncated
  /// The operating system reported an error, or the read took too long; a later read may succeed.
  kUnreadable,
  kNoMemory,  ///< memory ran out; a later read may succeed
};

struct BlobRange {
  uint32_t blob = 0;
  uint32_t offset_bytes = 0;
  uint32_t bytes = 0;
};

/// Subject of a report about a store.
enum class StoreFault {
  kDamaged,     ///< a blob does not match its checksum, or the file changed in place
  kUnreadable,  ///< the operating system cannot read the file, or can read it again
};

struct BlobReaderOptions {
  /// Interval of checks for changes of the file. After a change all blobs are verified again.
  std::chrono::nanoseconds check_file_every = std::chrono::milliseconds(20);
  /// Time after which a damaged blob is verified again, because the store may have been repaired.
  std::chrono::seconds retry_damaged{10};
  /// Shortest time between two reports that the same store cannot be read.
  std::chrono::seconds report_unreadable_every{10};
  /// A function that receives a line for the operator when a blob is damaged, when the file has changed in
  /// place, when the file cannot be read, and when it can be read again. Any thread can call the function,
  /// also after the server's end: see DiskReaders::join().
  std::function<void(StoreFault, std::string_view)> report = [](StoreFault, std::string_view) {};
  /// If false, readHot() always returns kCold, as for a file on a network or FUSE file system.
  bool hot_reads = true;
  /// A function that reads like lode::readAt() and sets errno on failure. The function may wait for the disk.
  std::function<std::optional<size_t>(int file, uint64_t offset, std::span<std::byte> bytes)> read = readAt;
};

/// Reads blobs of one store. Verifies a blob's checksum at its first read and again after the file has
/// changed. Thread safe.
class BlobReader {
 public:
  BlobReader(store::Reader reader, BlobReaderOptions options);

  /// Reads a range of a blob without waiting for the disk. @param into  buffer of at least range.bytes.
  ReadResult readHot(const BlobRange& range, std::span<std::byte> into) const noexcept;
  /// Reads a range of a blob, and waits for the disk if necessary. If the blob is not verified yet, reads the
  /// whole blob.
  ReadResult readCold(const BlobRange& range, std::span<std::byte> into) const noexcept;
  /// Reports that a read of the store has not ended within `deadline`.
  void noteLateRead(std::chrono::nanoseconds deadline) const noexcept;

  const store::Reader& store() const noexcept { return reader_; }
  /// Returns true if `file` is the status of this reader's file and the file has not changed since the reader
  /// opened it.
  bool isStill(const struct stat& file) const noexcept;
  /// Returns the number of reads of damaged blobs.
  uint64_t damagedReads() const noexcept { return damaged_reads_.load(std::memory_order_relaxed); }

 private:
  enum class Trust : uint32_t { kUnchecked, kGood, kDamaged };
  /// The fields of a file's status that change with its contents.
  struct FileState {
    uint64_t device = 0, inode = 0, bytes = 0;
    int64_t changed_ns = 0, modified_ns = 0;
    explicit FileState(const struct stat& file) noexcept;
    bool operator==(const FileState&) const = default;
  };

  Trust trustIn(uint32_t blob, uint32_t generation) const noexcept;
  void note(uint32_t blob, uint32_t generation, Trust trust) const noexcept;
  uint32_t currentGeneration() const noexcept;
  void checkFile() const noexcept;
  ReadResult checkHot(const BlobRange& range, std::span<std::byte> into, uint32_t generation) const noexcept;
  ReadResult bad(const BlobRange& range, uint32_t generation, std::string_view why) const noexcept;
  ReadResult readAndCheck(const BlobRange& range, std::span<std::byte> into, uint32_t generation) const;
  ReadResult unreadable() const noexcept;
  void noteUnreadable(std::string_view why) const noexcept;
  void noteReadable() const noexcept;
  template <typename... Parts>
  void report(StoreFault fault, const Parts&... parts) const noexcept;

  store::Reader reader_;
  BlobReaderOptions options_;
  /// Flags of preadv2() for reads that do not wait; empty if any read from the file system may wait, so that
  /// readHot() always returns kCold.
  std::optional<int> hot_flags_;
  std::unique_ptr<std::atomic<uint32_t>[]> notes_;
  mutable std::atomic<uint32_t> generation_{0};  ///< incremented when the file changes
  mutable std::atomic<int64_t> checked_ns_{0};   ///< time of the last check of the file
  mutable std::mutex file_mutex_;
  mutable FileState file_;  ///< guarded by file_mutex_
  mutable std::atomic<uint64_t> damaged_reads_{0};
  /// True if the store was reported as unreadable and no read has succeeded since then.
  mutable std::atomic<bool> is_unreadable_{false};
  mutable std::atomic<int64_t> reported_ns_{0};  ///< time of the last report that the store is unreadable
};

}  // namespace lode::serve
