#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

namespace lode::ingest {

/// What a build has finished, in the order in which it did: a file of entries, each with its length, its
/// place in the order and a checksum. An entry is appended when the data that it vouches for are on the disk,
/// and is there itself when append() returns. A kill can tear the last entry only; from the first entry that
/// is not whole on, the file counts as not written. Not thread safe.
class Journal {
 public:
  static constexpr uint64_t kMaxEntryBytes = 1ull << 33;

  using Sink = std::function<void(uint32_t kind, std::span<const std::byte> bytes)>;

  /// An empty one, over what may be there. @throws Error kIo.
  static Journal create(const std::filesystem::path& path);

  /// Gives the whole entries of a journal to `sink`, cuts off what is behind them, and goes on there. One
  /// that was killed while it was made is made anew.
  /// @throws Error kIo, kFormat (no journal of this version), and what the sink throws.
  static Journal open(const std::filesystem::path& path, const Sink& sink);

  ~Journal();
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;

  /// @throws Error kIo, kLimit.
  void append(uint32_t kind, std::span<const std::byte> bytes);
  uint64_t entries() const noexcept { return entries_; }

 private:
  Journal(std::filesystem::path path, int flags);
  void readHeader();
  bool readEntry(uint64_t file_bytes, const Sink& sink);

  std::filesystem::path path_;
  int file_ = -1;
  uint64_t end_ = 0;  ///< of the last whole entry
  uint64_t entries_ = 0;
};

}  // namespace lode::ingest
