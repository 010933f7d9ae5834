#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/disk/temporary_folder.h"

namespace lode::ingest {

/// External merge sort of fixed-size records by a 64-bit key. The sort is stable, so the result does not
/// depend on the memory budget. Records that fit in memory are not written to disk; otherwise one file holds
/// all sorted runs, one after another. Call all functions from one thread. Source: Knuth, The Art of Computer
/// Programming 3, 5.4.1.
class RecordSorter {
 public:
  using Progress = std::function<void(uint64_t done, uint64_t total)>;

  /// @param memory_bytes  memory for the records of one run, and later for the buffers of the merge.
  /// @param runs  file for the runs; the sorter creates the file only if the records do not fit in memory.
  RecordSorter(size_t record_bytes, uint64_t memory_bytes, TemporaryFile runs, unsigned threads = 1);
  ~RecordSorter();

  /// Reserves memory for `records` records, at most for a full run.
  void reserve(uint64_t records);
  void push(uint64_t key, std::span<const std::byte> record);
  uint64_t size() const noexcept { return size_; }
  uint64_t temporaryBytes() const noexcept { return temporary_bytes_; }

  /// Returns the number of runs on disk.
  size_t runCount() const noexcept { return runs_.size(); }
  /// Writes the records in memory as a run.
  void spill(const Progress& progress = {});
  /// Syncs the runs to disk and writes their end offsets to `record`.
  void save(RecordWriter& record);
  /// Restores the runs that save() described. Call restore() before the first push().
  /// @throws Error kIo, kFormat.
  void restore(RecordReader& record);

  /// Ends the input; next() then returns the records in order.
  /// @param progress  reports how far the records still in memory are sorted and, if they become a run,
  /// written.
  void finish(const Progress& progress = {});

  struct Record {
    uint64_t key = 0;
    std::span<const std::byte> bytes;  ///< valid until the next call of next()
  };
  std::optional<Record> next();

 private:
  struct Run;
  struct Order {
    uint64_t key;
    uint32_t index;
    bool operator<(const Order& other) const noexcept {
      return key != other.key ? key < other.key : index < other.index;
    }
  };
  bool later(uint32_t a, uint32_t b) const noexcept;
  void sortOn(unsigned threads, size_t begin, size_t end, const Progress& progress, uint64_t total);
  void sortPieces(size_t begin, size_t end, const Progress& progress, uint64_t total);
  std::optional<Record> nextOfMemory();
  std::optional<Record> nextOfRuns();

  const size_t record_bytes_;
  const uint64_t memory_bytes_;
  const size_t capacity_;
  const TemporaryFile file_;
  const unsigned threads_;
  uint64_t size_ = 0;
  uint64_t temporary_bytes_ = 0;
  std::vector<std::byte> held_;
  std::vector<Order> order_;
  std::atomic<size_t> sorted_ = 0;  ///< number of sorted elements of order_, for progress
  size_t next_held_ = 0;
  bool top_given_ = false;
  std::optional<Spool> spool_;  ///< all runs; closed after the last record
  std::vector<std::unique_ptr<Run>> runs_;
  std::vector<uint32_t> heap_;  ///< min-heap of run indices, ordered by current key, then by index
};

}  // namespace lode::ingest
