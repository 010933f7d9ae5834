#include "server/ingest/disk/journal.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/codec/blob.h"
#include "common/error.h"
#include "common/io/file_io.h"

namespace lode::ingest {
namespace {

// Magic bytes, which end in the format version. Change the version whenever the format of any entry changes.
constexpr std::array<char, 8> kMagic{'L', 'O', 'D', 'E', 'J', 'N', '0', '7'};

/// Precedes the bytes of each entry. The checksum covers the other fields and the bytes.
struct EntryHeader {
  uint64_t checksum = 0;
  uint64_t number = 0;  ///< sequence number, from 0
  uint64_t bytes = 0;
  uint64_t kind = 0;
};
constexpr size_t kCheckedFrom = sizeof(EntryHeader::checksum);

[[noreturn]] void fail(const std::filesystem::path& path, const char* what) {
  throw Error(ErrorCode::kIo,
              std::string("cannot ") + what + " " + path.string() + ": " + fileErrorInWords(errno));
}

/// Fills `bytes` from the file at `offset`. @return false if the file is too short.
bool readWhole(int file, const std::filesystem::path& path, uint64_t offset, std::span<std::byte> bytes) {
  const std::optional<size_t> got = readAt(file, offset, bytes);
  if (!got) fail(path, "read");
  return *got == bytes.size();
}

void writeToDisk(int file, const std::filesystem::path& path, uint64_t offset,
                 std::span<const std::byte> bytes) {
  if (!writeAt(file, offset, bytes)) fail(path, "write");
  if (::fdatasync(file) != 0) fail(path, "sync");
}

}  // namespace

Journal::Journal(std::filesystem::path path, int flags) : path_(std::move(path)) {
  file_ = ::open(path_.c_str(), flags | O_CLOEXEC, 0600);
  if (file_ < 0) fail(path_, "open");
}

Journal::~Journal() {
  if (file_ >= 0) ::close(file_);
}

Journal::Journal(Journal&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::exchange(other.file_, -1)),
      end_(other.end_),
      entries_(other.entries_) {}

Journal Journal::create(const std::filesystem::path& path) {
  Journal journal(path, O_RDWR | O_CREAT | O_TRUNC);
  writeToDisk(journal.file_, path, 0, std::as_bytes(std::span(kMagic)));
  journal.end_ = kMagic.size();
  return journal;
}

Journal Journal::open(const std::filesystem::path& path, const Sink& sink) {
  Journal journal(path, O_RDWR);
  if (journal.fileBytes() == 0) return create(path);
  journal.readEntries(sink);
  if (::ftruncate(journal.file_, static_cast<off_t>(journal.end_)) != 0) fail(path, "truncate");
  return journal;
}

void Journal::read(const std::filesystem::path& path, const Sink& sink) {
  Journal journal(path, O_RDONLY);
  if (journal.fileBytes() > 0) journal.readEntries(sink);  // else it was just created
}

uint64_t Journal::fileBytes() const {
  struct stat status {};
  if (::fstat(file_, &status) != 0) fail(path_, "examine");
  return static_cast<uint64_t>(status.st_size);
}

void Journal::readEntries(const Sink& sink) {
  const uint64_t file_bytes = fileBytes();
  readHeader();
  while (readEntry(file_bytes, sink)) {
  }
}

void Journal::readHeader() {
  std::array<char, kMagic.size()> magic{};
  if (!readWhole(file_, path_, 0, std::as_writable_bytes(std::span(magic))) || magic != kMagic) {
    throw Error(ErrorCode::kFormat,
                path_.string() + ": is not a build journal of this version; build without --resume");
  }
  end_ = kMagic.size();
}

/// Reads the next entry and passes it to the sink. @return false if no intact entry follows.
bool Journal::readEntry(uint64_t file_bytes, const Sink& sink) {
  EntryHeader header;
  if (file_bytes < end_ || file_bytes - end_ < sizeof(header)) return false;
  if (!readWhole(file_, path_, end_, std::as_writable_bytes(std::span(&header, 1)))) return false;
  if (header.number != entries_ || header.bytes > kMaxEntryBytes ||
      header.bytes > file_bytes - end_ - sizeof(header)) {
    return false;
  }
  std::vector<std::byte> entry(sizeof(header) + header.bytes);
  if (!readWhole(file_, path_, end_, entry)) return false;
  if (checksum(std::span(entry).subspan(kCheckedFrom)) != header.checksum) return false;
  sink(static_cast<uint32_t>(header.kind), std::span(entry).subspan(sizeof(header)));
  end_ += entry.size();
  ++entries_;
  return true;
}

void Journal::append(uint32_t kind, std::span<const std::byte> bytes) {
  if (bytes.size() > kMaxEntryBytes) {
    throw Error(ErrorCode::kLimit, path_.string() + ": entry has " + std::to_string(bytes.size()) +
                                       " bytes; the limit is " + std::to_string(kMaxEntryBytes));
  }
  EntryHeader header{0, entries_, bytes.size(), kind};
  std::vector<std::byte> entry(sizeof(header) + bytes.size());
  std::memcpy(entry.data(), &header, sizeof(header));
  if (!bytes.empty()) std::memcpy(entry.data() + sizeof(header), bytes.data(), bytes.size());
  header.checksum = checksum(std::span(entry).subspan(kCheckedFrom));
  std::memcpy(entry.data(), &header, sizeof(header));
  writeToDisk(file_, path_, end_, entry);
  end_ += entry.size();
  ++entries_;
}

}  // namespace lode::ingest
