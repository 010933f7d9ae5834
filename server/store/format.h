#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/codec/blob.h"
#include "common/codec/model_summary.h"

/// Encoding of a store file's fixed parts. A store has a header, blobs back to back, a blob table and a
/// footer (docs/store-format.md). All numbers are little-endian.
namespace lode::store {

constexpr uint32_t kFormatVersion = 4;
constexpr size_t kHeaderBytes = 188;
constexpr size_t kTableEntryBytes = 28;
constexpr size_t kFooterBytes = 24;

/// Content of the header. The encoded header does not contain the summary's `name`, and contains only the
/// blob numbers of `root_page` and `textures`.
struct FileHeader {
  ModelSummary summary;
  uint64_t table_offset = 0;
  uint32_t blobs = 0;
  uint64_t table_checksum = 0;
};

/// Entry of the blob table. A blob's offset follows from the sizes of the blobs before it.
struct TableEntry {
  uint32_t bytes = 0;
  uint64_t checksum = 0;
  Digest digest;
};

std::array<std::byte, kHeaderBytes> encodeHeader(const FileHeader& header);
std::vector<std::byte> encodeTable(std::span<const TableEntry> entries);
std::array<std::byte, kFooterBytes> encodeFooter(std::span<const std::byte, kHeaderBytes> header);

/// Returns true if the bytes begin with the magic of a store.
bool beginsAsStore(std::span<const std::byte> bytes) noexcept;
/// Decodes the header. Checks magic, version, checksum and the range of every field. Checks that the parts
/// fill the file exactly.
/// @throws Error kInput (not a store, or a store of another version) or kFormat.
FileHeader decodeHeader(std::span<const std::byte, kHeaderBytes> bytes, uint64_t file_bytes);
/// Decodes the blob table. Checks its checksum, sizes and limits against the header. Checks that the blobs
/// fill the space between header and table. @throws Error kFormat, kLimit.
std::vector<TableEntry> decodeTable(std::span<const std::byte> bytes, const FileHeader& header);
/// Checks the footer against the header. @throws Error kFormat.
void checkFooter(std::span<const std::byte, kFooterBytes> footer,
                 std::span<const std::byte, kHeaderBytes> header);

/// Returns the digest of the header and the blob table. The digest does not cover the header's own build id
/// and checksum.
Digest computeBuildId(const FileHeader& header, std::span<const std::byte> table);

}  // namespace lode::store
