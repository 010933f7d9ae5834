#include "server/serve/session/blob_reader.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/uio.h>
#include <sys/vfs.h>
#include <time.h>
#include <unistd.h>

#include "common/codec/blob.h"
#include "common/error.h"

namespace lode::serve {

namespace {

/// Largest size of a blob that the serving thread verifies itself if the blob is in the page cache. Verifying
/// such a blob takes about 50 µs.
constexpr uint32_t kMaxCheckedHotBytes = 256u << 10;

// A note on a blob contains the blob's Trust (2 bits), the generation of the file for which the note is valid
// (14 bits) and the second of the note's creation (16 bits). Notes of other generations are ignored.
constexpr uint32_t kGenerations = 1u << 14, kSeconds = 1u << 16;

int64_t nowNs() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
  return now.tv_sec * 1'000'000'000 + now.tv_nsec;
}

uint32_t nowSecond() noexcept { return static_cast<uint32_t>(nowNs() / 1'000'000'000) % kSeconds; }

struct stat statusOf(int descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0)
    throw Error(ErrorCode::kIo, std::string("cannot get the status of a store: ") + std::strerror(errno));
  return status;
}

/// Returns the flags for preadv2() that avoid waiting for the disk. File systems in memory reject RWF_NOWAIT,
/// but reads from them never wait. Returns nothing for other file systems that reject RWF_NOWAIT, such as
/// network and FUSE file systems, because any call on them may wait, even fstat().
std::optional<int> flagsForHot(int descriptor) noexcept {
  struct statfs system {};
  const bool in_memory =
      fstatfs(descriptor, &system) == 0 && (system.f_type == TMPFS_MAGIC || system.f_type == RAMFS_MAGIC);
  if (in_memory) return 0;
  std::byte first{};
  const iovec place{&first, 1};
  if (preadv2(descriptor, &place, 1, 0, RWF_NOWAIT) < 0 && errno == EOPNOTSUPP) return std::nullopt;
  return RWF_NOWAIT;
}

bool readWhole(int descriptor, uint64_t offset, std::span<std::byte> into, int flags) noexcept {
  const iovec place{into.data(), into.size()};
  return preadv2(descriptor, &place, 1, static_cast<off_t>(offset), flags) ==
         static_cast<ssize_t>(into.size());
}

}  // namespace

BlobReader::FileState::FileState(const struct stat& file) noexcept
    : device(file.st_dev),
      inode(file.st_ino),
      bytes(static_cast<uint64_t>(file.st_size)),
      changed_ns(file.st_ctim.tv_sec * 1'000'000'000 + file.st_ctim.tv_nsec),
      modified_ns(file.st_mtim.tv_sec * 1'000'000'000 + file.st_mtim.tv_nsec) {}

BlobReader::BlobReader(store::Reader reader, BlobReaderOptions options)
    : reader_(std::move(reader)),
      options_(std::move(options)),
      hot_flags_(options_.hot_reads ? flagsForHot(reader_.fileDescriptor()) : std::nullopt),
      notes_(std::make_unique<std::atomic<uint32_t>[]>(size_t{reader_.blobCount()} + 1)),
      checked_ns_(nowNs()),
      file_(statusOf(reader_.fileDescriptor())) {}

bool BlobReader::isStill(const struct stat& file) const noexcept {
  const std::lock_guard lock(file_mutex_);
  return FileState(file) == file_ && generation_.load(std::memory_order_relaxed) == 0;
}

template <typename... Parts>
void BlobReader::report(StoreFault fault, const Parts&... parts) const noexcept {
  try {
    std::string line;
    (line.append(parts), ...);
    options_.report(fault, line);
  } catch (const std::exception&) {  // ignore a failed report, because serving must go on
  }
}

BlobReader::Trust BlobReader::trustIn(uint32_t blob, uint32_t generation) const noexcept {
  const uint32_t note = notes_[blob].load(std::memory_order_acquire);
  if ((note >> 2) % kGenerations != generation % kGenerations) return Trust::kUnchecked;
  const auto trust = static_cast<Trust>(note & 3);
  const uint32_t age_s = (nowSecond() + kSeconds - (note >> 16)) % kSeconds;
  const bool retry = trust == Trust::kDamaged && age_s >= options_.retry_damaged.count();
  return retry ? Trust::kUnchecked : trust;
}

void BlobReader::note(uint32_t blob, uint32_t generation, Trust trust) const noexcept {
  notes_[blob].store(nowSecond() << 16 | (generation % kGenerations) << 2 | static_cast<uint32_t>(trust),
                     std::memory_order_release);
}

uint32_t BlobReader::currentGeneration() const noexcept {
  const int64_t now = nowNs();
  int64_t last = checked_ns_.load(std::memory_order_relaxed);
  if (now - last >= options_.check_file_every.count() &&
      checked_ns_.compare_exchange_strong(last, now, std::memory_order_relaxed))
    checkFile();
  return generation_.load(std::memory_order_acquire);
}

void BlobReader::checkFile() const noexcept {
  struct stat status {};
  if (fstat(reader_.fileDescriptor(), &status) != 0) return;
  bool was_written = false;
  {
    const std::lock_guard lock(file_mutex_);
    const FileState now(status);
    if (now == file_) return;
    // If the file is renamed or removed, only its ctime changes.
    was_written = now.bytes != file_.bytes || now.modified_ns != file_.modified_ns;
    file_ = now;
    generation_.fetch_add(1, std::memory_order_release);
  }
  if (was_written)
    report(StoreFault::kDamaged, "the store of model '", reader_.summary().name,
           "' changed in place; its blobs are verified again. Rename new stores into place instead");
}

ReadResult BlobReader::readHot(const BlobRange& range, std::span<std::byte> into) const noexcept {
  if (!hot_flags_) return ReadResult::kCold;
  const uint32_t generation = currentGeneration();
  switch (trustIn(range.blob, generation)) {
    case Trust::kUnchecked:
      return checkHot(range, into, generation);
    case Trust::kDamaged:
      damaged_reads_.fetch_add(1, std::memory_order_relaxed);
      return ReadResult::kDamaged;
    case Trust::kGood:
      break;
  }
  const uint64_t offset = reader_.blob(range.blob).offset + range.offset_bytes;
  const bool done = readWhole(reader_.fileDescriptor(), offset, into.first(range.bytes), *hot_flags_);
  return done ? ReadResult::kDone : ReadResult::kCold;
}

ReadResult BlobReader::checkHot(const BlobRange& range, std::span<std::byte> into,
                                uint32_t generation) const noexcept {
  const store::BlobEntry& entry = reader_.blob(range.blob);
  if (entry.bytes > kMaxCheckedHotBytes) return ReadResult::kCold;
  thread_local std::vector<std::byte> room;
  const bool all = range.bytes == entry.bytes;
  try {
    if (!all) room.resize(entry.bytes);
  } catch (const std::exception&) {
    return ReadResult::kCold;
  }
  const std::span<std::byte> blob = all ? into.first(range.bytes) : std::span(room).first(entry.bytes);
  if (!readWhole(reader_.fileDescriptor(), entry.offset, blob, *hot_flags_)) return ReadResult::kCold;
  if (checksum(blob) != entry.checksum) return bad(range, generation, "the checksum does not match");
  note(range.blob, generation, Trust::kGood);
  if (!all) std::memcpy(into.data(), blob.data() + range.offset_bytes, range.bytes);
  return ReadResult::kDone;
}

ReadResult BlobReader::readCold(const BlobRange& range, std::span<std::byte> into) const noexcept {
  const uint32_t generation = currentGeneration();
  const Trust trust = trustIn(range.blob, generation);
  if (trust == Trust::kDamaged) {
    damaged_reads_.fetch_add(1, std::memory_order_relaxed);
    return ReadResult::kDamaged;
  }
  try {
    if (trust == Trust::kUnchecked) return readAndCheck(range, into, generation);
  } catch (const std::exception&) {
    return ReadResult::kNoMemory;
  }
  const store::BlobEntry& entry = reader_.blob(range.blob);
  const uint32_t end = range.offset_bytes + range.bytes;
  if (end < entry.bytes)  // ask the system to load the rest of the blob, which is read next
    posix_fadvise(reader_.fileDescriptor(), static_cast<off_t>(entry.offset + end), entry.bytes - end,
                  POSIX_FADV_WILLNEED);
  const auto got =
      options_.read(reader_.fileDescriptor(), entry.offset + range.offset_bytes, into.first(range.bytes));
  if (!got) return unreadable();
  noteReadable();
  return *got == range.bytes ? ReadResult::kDone : bad(range, generation, "the file was truncated");
}

/// Reads and verifies the whole blob. @throws std::bad_alloc.
ReadResult BlobReader::readAndCheck(const BlobRange& range, std::span<std::byte> into,
                                    uint32_t generation) const {
  const store::BlobEntry& entry = reader_.blob(range.blob);
  std::vector<std::byte> blob(entry.bytes);
  const auto got = options_.read(reader_.fileDescriptor(), entry.offset, blob);
  if (!got) return unreadable();
  noteReadable();
  if (*got < blob.size()) return bad(range, generation, "the file was truncated");
  if (checksum(blob) != entry.checksum) return bad(range, generation, "the checksum does not match");
  note(range.blob, generation, Trust::kGood);
  std::memcpy(into.data(), blob.data() + range.offset_bytes, range.bytes);
  return ReadResult::kDone;
}

ReadResult BlobReader::bad(const BlobRange& range, uint32_t generation, std::string_view why) const noexcept {
  damaged_reads_.fetch_add(1, std::memory_order_relaxed);
  const uint32_t before = notes_[range.blob].load(std::memory_order_acquire);
  const bool known = static_cast<Trust>(before & 3) == Trust::kDamaged &&
                     (before >> 2) % kGenerations == generation % kGenerations;
  note(range.blob, generation, Trust::kDamaged);
  if (!known)
    report(StoreFault::kDamaged, "blob ", std::to_string(range.blob), " of model '", reader_.summary().name,
           "': ", why);
  return ReadResult::kDamaged;
}

/// Reports the errno of a failed read.
ReadResult BlobReader::unreadable() const noexcept {
  noteUnreadable(std::strerror(errno));
  return ReadResult::kUnreadable;
}

void BlobReader::noteLateRead(std::chrono::nanoseconds deadline) const noexcept {
  const double seconds = std::chrono::duration<double>(deadline).count();
  char why[64];
  std::snprintf(why, sizeof why, "a read has not ended within %g s", seconds);
  noteUnreadable(why);
}

void BlobReader::noteUnreadable(std::string_view why) const noexcept {
  if (is_unreadable_.load(std::memory_order_relaxed)) return;
  const int64_t now = nowNs();
  int64_t last = reported_ns_.load(std::memory_order_relaxed);
  const auto every = std::chrono::nanoseconds(options_.report_unreadable_every).count();
  if (last != 0 && now - last < every) return;
  if (!reported_ns_.compare_exchange_strong(last, now, std::memory_order_relaxed)) return;
  is_unreadable_.store(true, std::memory_order_relaxed);
  report(StoreFault::kUnreadable, "the store of model '", reader_.summary().name, "' cannot be read: ", why,
         "; requests end with an error until it can be read");
}

void BlobReader::noteReadable() const noexcept {
  if (is_unreadable_.load(std::memory_order_relaxed) && is_unreadable_.exchange(false))
    report(StoreFault::kUnreadable, "the store of model '", reader_.summary().name, "' can be read again");
}

}  // namespace lode::serve
