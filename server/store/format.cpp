#include "server/store/format.h"

#include <bit>
#include <cmath>
#include <concepts>
#include <cstring>
#include <string>

#include "common/error.h"
#include "common/limits.h"
#include "common/node_key.h"

namespace lode::store {
namespace {

constexpr std::array<char, 8> kMagic{'L', 'O', 'D', 'E', '\r', '\n', '\x1a', '\n'};
constexpr std::array<char, 8> kEndMagic{'L', 'O', 'D', 'E', '-', 'E', 'N', 'D'};
constexpr size_t kHeaderChecksumAt = kHeaderBytes - sizeof(uint64_t);

/// Writes little-endian numbers to a buffer.
class Put {
 public:
  explicit Put(std::span<std::byte> out) : out_(out) {}
  template <std::unsigned_integral T>
  void number(T value) {
    for (size_t i = 0; i < sizeof(T); ++i) out_[at_++] = static_cast<std::byte>(value >> 8 * i & 0xff);
  }
  void number(float value) { number(std::bit_cast<uint32_t>(value)); }
  void number(double value) { number(std::bit_cast<uint64_t>(value)); }
  void raw(std::span<const std::byte> bytes) {
    std::memcpy(&out_[at_], bytes.data(), bytes.size());
    at_ += bytes.size();
  }
  size_t at() const noexcept { return at_; }

 private:
  std::span<std::byte> out_;
  size_t at_ = 0;
};

/// Reads little-endian numbers from a buffer whose size the caller has checked.
class Take {
 public:
  explicit Take(std::span<const std::byte> in) : in_(in) {}
  template <std::unsigned_integral T>
  void number(T& value) {
    value = 0;
    for (size_t i = 0; i < sizeof(T); ++i)
      value = static_cast<T>(value | static_cast<T>(std::to_integer<T>(in_[at_++]) << 8 * i));
  }
  void number(float& value) { value = std::bit_cast<float>(get<uint32_t>()); }
  void number(double& value) { value = std::bit_cast<double>(get<uint64_t>()); }
  template <typename T>
  T get() {
    T value;
    number(value);
    return value;
  }
  void raw(std::span<std::byte> bytes) {
    std::memcpy(bytes.data(), &in_[at_], bytes.size());
    at_ += bytes.size();
  }

 private:
  std::span<const std::byte> in_;
  size_t at_ = 0;
};

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::kFormat, what); }

std::span<const std::byte> asBytes(const std::array<char, 8>& text) { return std::as_bytes(std::span(text)); }

void checkGrid(const ModelSummary& summary) {
  const Lattice& lattice = summary.lattice;
  if (!isLatticeStep(lattice.step))
    fail("header: the lattice's step is not 4, 5, 6 or 7 times a power of two, from 2^-100 to 2^60");
  for (int axis = 0; axis < 3; ++axis) {
    const double origin = lattice.origin[axis];
    if (!std::isfinite(origin) || std::fmod(origin, lattice.step) != 0)
      fail("header: the lattice's origin is not a multiple of its step");
    if (summary.box.max[axis] > kMaxLattice || summary.box.min[axis] > kMaxLattice)
      fail("header: the box is outside the lattice");
  }
}

void checkCounts(const ModelSummary& summary) {
  if ((summary.attributes.bits & ~(AttributeSet::kAll | AttributeSet::kComputedNormal)) != 0)
    fail("header: unknown attributes");
  if (summary.nodes == 0 || summary.nodes > kMaxNodes)
    fail("header: " + std::to_string(summary.nodes) + " nodes, the limit is " + std::to_string(kMaxNodes));
  if (summary.depth > static_cast<uint32_t>(kMaxDepth)) fail("header: the hierarchy is too deep");
  if (!std::isfinite(summary.max_error_model) || summary.max_error_model < 0)
    fail("header: the error is not a finite number");
}

}  // namespace

std::array<std::byte, kHeaderBytes> encodeHeader(const FileHeader& header) {
  std::array<std::byte, kHeaderBytes> bytes{};
  const ModelSummary& summary = header.summary;
  Put put(bytes);
  put.raw(asBytes(kMagic));
  put.number(kFormatVersion);
  put.number(static_cast<uint32_t>(kHeaderBytes));
  put.number(summary.bytes);
  put.number(header.table_offset);
  put.number(header.blobs);
  put.number(summary.root_page.number);
  put.raw(summary.build_id.bytes);
  for (int axis = 0; axis < 3; ++axis) put.number(summary.lattice.origin[axis]);
  put.number(summary.lattice.step);
  for (int axis = 0; axis < 3; ++axis) put.number(summary.box.min[axis]);
  for (int axis = 0; axis < 3; ++axis) put.number(summary.box.max[axis]);
  put.number(uint32_t{summary.attributes.bits});
  put.number(summary.triangles_per_node);
  put.number(summary.triangles);
  put.number(summary.dropped);
  put.number(summary.stored_triangles);
  put.number(summary.nodes);
  put.number(summary.payloads);
  put.number(summary.depth);
  put.number(summary.max_error_model);
  put.number(summary.textures.number);
  put.number(header.table_checksum);
  put.number(checksum(std::span<const std::byte>(bytes).first<kHeaderChecksumAt>()));
  return bytes;
}

bool beginsAsStore(std::span<const std::byte> bytes) noexcept {
  return bytes.size() >= kMagic.size() && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

FileHeader decodeHeader(std::span<const std::byte, kHeaderBytes> bytes, uint64_t file_bytes) {
  if (!beginsAsStore(bytes))
    throw Error(ErrorCode::kInput, "is not a store: give a .lode file, or build one with lodestreamd build");
  Take take(bytes.subspan<kMagic.size()>());
  if (const auto version = take.get<uint32_t>(); version != kFormatVersion)
    throw Error(ErrorCode::kInput, "has format version " + std::to_string(version) +
                                       ", this program reads version " + std::to_string(kFormatVersion) +
                                       ": build the store anew, or use a program of its version");
  Take sum(bytes.last<sizeof(uint64_t)>());
  if (sum.get<uint64_t>() != checksum(bytes.first<kHeaderChecksumAt>()))
    fail("header: the checksum does not match");
  if (take.get<uint32_t>() != kHeaderBytes) fail("header: wrong size");
  FileHeader header;
  ModelSummary& summary = header.summary;
  take.number(summary.bytes);
  if (file_bytes < summary.bytes)
    fail("truncated: " + std::to_string(file_bytes) + " of " + std::to_string(summary.bytes) + " bytes");
  if (file_bytes > summary.bytes)
    fail(std::to_string(file_bytes - summary.bytes) + " extra bytes at the end");
  take.number(header.table_offset);
  take.number(header.blobs);
  take.number(summary.root_page.number);
  take.raw(summary.build_id.bytes);
  for (int axis = 0; axis < 3; ++axis) take.number(summary.lattice.origin[axis]);
  take.number(summary.lattice.step);
  for (int axis = 0; axis < 3; ++axis) take.number(summary.box.min[axis]);
  for (int axis = 0; axis < 3; ++axis) take.number(summary.box.max[axis]);
  const auto attribute_bits = take.get<uint32_t>();
  if (attribute_bits > 0xff) fail("header: unknown attributes");
  summary.attributes.bits = static_cast<uint8_t>(attribute_bits);
  take.number(summary.triangles_per_node);
  take.number(summary.triangles);
  take.number(summary.dropped);
  take.number(summary.stored_triangles);
  take.number(summary.nodes);
  take.number(summary.payloads);
  take.number(summary.depth);
  take.number(summary.max_error_model);
  take.number(summary.textures.number);
  take.number(header.table_checksum);
  checkGrid(summary);
  checkCounts(summary);
  const uint64_t behind_blobs = uint64_t{header.blobs} * kTableEntryBytes + kFooterBytes;
  if (header.table_offset < kHeaderBytes || summary.bytes < kHeaderBytes + behind_blobs ||
      header.table_offset != summary.bytes - behind_blobs)
    fail("header: blob table and footer do not fill the rest of the file");
  if (summary.root_page.number == 0 || summary.root_page.number > header.blobs)
    fail("header: the root page is not a blob of this store");
  if (summary.textures.number > header.blobs) fail("header: the texture set is not a blob of this store");
  return header;
}

std::vector<std::byte> encodeTable(std::span<const TableEntry> entries) {
  std::vector<std::byte> bytes(entries.size() * kTableEntryBytes);
  Put put(bytes);
  for (const TableEntry& entry : entries) {
    put.number(entry.bytes);
    put.number(entry.checksum);
    put.raw(entry.digest.bytes);
  }
  return bytes;
}

std::vector<TableEntry> decodeTable(std::span<const std::byte> bytes, const FileHeader& header) {
  if (bytes.size() != size_t{header.blobs} * kTableEntryBytes) fail("blob table: wrong size");
  if (checksum(bytes) != header.table_checksum) fail("blob table: the checksum does not match");
  std::vector<TableEntry> entries(header.blobs);
  Take take(bytes);
  uint64_t end = kHeaderBytes;
  for (TableEntry& entry : entries) {
    take.number(entry.bytes);
    take.number(entry.checksum);
    take.raw(entry.digest.bytes);
    if (entry.bytes == 0) fail("blob table: an empty blob");
    if (entry.bytes > kMaxBlobBytes)
      throw Error(ErrorCode::kLimit, "blob table: a blob of " + std::to_string(entry.bytes) +
                                         " bytes, the limit is " + std::to_string(kMaxBlobBytes));
    end += entry.bytes;
  }
  if (end != header.table_offset) fail("blob table: the blobs do not fill the space before it");
  return entries;
}

std::array<std::byte, kFooterBytes> encodeFooter(std::span<const std::byte, kHeaderBytes> header) {
  std::array<std::byte, kFooterBytes> bytes{};
  Put put(bytes);
  put.raw(header.last<sizeof(uint64_t)>());
  put.raw(asBytes(kEndMagic));
  put.number(checksum(std::span<const std::byte>(bytes).first(put.at())));
  return bytes;
}

void checkFooter(std::span<const std::byte, kFooterBytes> footer,
                 std::span<const std::byte, kHeaderBytes> header) {
  const auto expected = encodeFooter(header);
  if (std::memcmp(footer.data(), expected.data(), kFooterBytes) != 0)
    fail("footer: does not match the header");
}

Digest computeBuildId(const FileHeader& header, std::span<const std::byte> table) {
  FileHeader anonymous = header;
  anonymous.summary.build_id = {};
  const auto head = encodeHeader(anonymous);
  std::vector<std::byte> index(head.begin(), head.begin() + kHeaderChecksumAt);
  index.insert(index.end(), table.begin(), table.end());
  return digestOf(index);
}

}  // namespace lode::store
