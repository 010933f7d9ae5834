#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/codec/blob.h"
#include "common/codec/model_summary.h"

/// The fixed parts of a store file, field by field as docs/store-format.md has them:
/// header, blobs back to back, blob table, footer. All numbers little-endian.
namespace lode::store {

constexpr uint32_t kFormatVersion = 4;
constexpr size_t kHeaderBytes = 188;
constexpr size_t kTableEntryBytes = 28;
constexpr size_t kFooterBytes = 24;

/// What the header says. Of the summary, `name` is not stored, and of `root_page` and
/// `textures` only the number is.
struct FileHeader {
  ModelSummary summary;
  uint64_t table_offset = 0;
  uint32_t blobs = 0;
  uint64_t table_checksum = 0;
};

/// One entry of the blob table; where the blob lies follows from the sizes of those before it.
struct TableEntry {
  uint32_t bytes = 0;
  uint64_t checksum = 0;
  Digest digest;
};

std::array<std::byte, kHeaderBytes> encodeHeader(const FileHeader& header);
std::vector<std::byte> encodeTable(std::span<const TableEntry> entries);
std::array<std::byte, kFooterBytes> encodeFooter(std::span<const std::byte, kHeaderBytes> header);

/// Checks magic, version, checksum and the range of every field, and that the parts fill the file exactly.
/// @throws Error kInput (no store, or of another version) or kFormat.
FileHeader decodeHeader(std::span<const std::byte, kHeaderBytes> bytes, uint64_t file_bytes);
/// Checks the table against the header: checksum, sizes, limits, and that the blobs fill the space between
/// header and table. @throws Error kFormat, kLimit.
std::vector<TableEntry> decodeTable(std::span<const std::byte> bytes, const FileHeader& header);
/// @throws Error kFormat.
void checkFooter(std::span<const std::byte, kFooterBytes> footer,
                 std::span<const std::byte, kHeaderBytes> header);

/// The hash of the index: of the header without its build id and checksum, and the blob table.
Digest computeBuildId(const FileHeader& header, std::span<const std::byte> table);

}  // namespace lode::store
