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

/// External sort of records of one size by a 64-bit key; records of equal keys keep the order in which they
/// came, so that the result does not depend on the memory given. What fits in memory never touches the disk.
/// To be called from one thread. Source: Knuth, The Art of Computer Programming 3, 5.4.1 (replacement by
/// sorted runs and merging). All runs lie in one file, behind each other, so that their number costs neither
/// files nor buffers.
class RecordSorter {
 public:
  using Progress = std::function<void(uint64_t done, uint64_t total)>;

  /// @param memory_bytes  for the records held before a run is written, and for the buffers of the merge.
  /// @param runs  where they are written, if there are any.
  /// @param threads  that sort.
  RecordSorter(size_t record_bytes, uint64_t memory_bytes, TemporaryFile runs, unsigned threads = 1);
  ~RecordSorter();

  /// Makes room for so many records, or what is held at most.
  void reserve(uint64_t records);
  void push(uint64_t key, std::span<const std::byte> record);
  uint64_t size() const noexcept { return size_; }
  uint64_t temporaryBytes() const noexcept { return temporary_bytes_; }

  /// The number of runs on the disk.
  size_t runCount() const noexcept { return runs_.size(); }
  /// Writes what is held as a run.
  void spill(const Progress& progress = {});
  /// Writes the runs to the disk for good, and notes in `record` where they are.
  void save(RecordWriter& record);
  /// Takes over the runs that save() noted, before any push; records follow those in the runs.
  /// @throws Error kIo, kFormat.
  void restore(RecordReader& record);

  /// No more records come in; next() gives them in order.
  /// @param progress  of sorting and writing what is still held.
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
  std::atomic<size_t> sorted_ = 0;  ///< of those in order_, for progress
  size_t next_held_ = 0;
  bool top_given_ = false;
  std::optional<Spool> spool_;  ///< of all runs; gone when the last record was taken
  std::vector<std::unique_ptr<Run>> runs_;
  std::vector<uint32_t> heap_;  ///< runs by (current key, run number), smallest on top
};

}  // namespace lode::ingest
