#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

namespace lode::ingest {

/// Record of a build's finished work: a file of entries, each with its length, sequence number and checksum.
/// Sync the data that an entry describes to disk before you call append(), which returns when the entry
/// itself is on disk. Killing the process can damage only the last entry. open() ignores the first damaged
/// entry and everything after it. Not thread safe.
class Journal {
 public:
  static constexpr uint64_t kMaxEntryBytes = 1ull << 33;

  using Sink = std::function<void(uint32_t kind, std::span<const std::byte> bytes)>;

  /// Creates an empty journal; replaces an existing file. @throws Error kIo.
  static Journal create(const std::filesystem::path& path);

  /// Passes the intact entries to `sink` and truncates the file after them. Creates a new journal if the file
  /// is empty.
  /// @throws Error kIo, kFormat (not a journal of this version), and exceptions of the sink.
  static Journal open(const std::filesystem::path& path, const Sink& sink);

  /// Passes the intact entries to `sink`. Does not change the file, so that any number of processes can read
  /// it. @throws Error kIo, kFormat (not a journal of this version), and exceptions of the sink.
  static void read(const std::filesystem::path& path, const Sink& sink);

  ~Journal();
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;

  /// Appends an entry and syncs the file to disk. @throws Error kIo, kLimit.
  void append(uint32_t kind, std::span<const std::byte> bytes);
  uint64_t entries() const noexcept { return entries_; }

 private:
  Journal(std::filesystem::path path, int flags);
  void readEntries(const Sink& sink);
  void readHeader();
  uint64_t fileBytes() const;
  bool readEntry(uint64_t file_bytes, const Sink& sink);

  std::filesystem::path path_;
  int file_ = -1;
  uint64_t end_ = 0;  ///< end of the last intact entry
  uint64_t entries_ = 0;
};

/// Decides when a build stage writes its next progress entry to the journal. The interval is 100 times the
/// time that the last entry took to write, so that entries cost about 1 % of the build time. The interval is
/// at most 10 s, so that a killed build loses at most 10 s of work.
class CheckpointClock {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr Clock::duration kLatest = std::chrono::seconds(10);

  explicit CheckpointClock(Clock::time_point now) : due_(now + kSoonest) {}

  bool isDue(Clock::time_point now) const noexcept { return now >= due_; }
  void noted(Clock::time_point began, Clock::time_point ended) noexcept {
    due_ = ended + std::clamp<Clock::duration>(kWorkPerEntry * (ended - began), kSoonest, kLatest);
  }

 private:
  static constexpr int kWorkPerEntry = 100;
  static constexpr Clock::duration kSoonest = std::chrono::milliseconds(50);

  Clock::time_point due_;
};

}  // namespace lode::ingest
