#include "server/ingest/nodes/treelet_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"

namespace lode::ingest {
namespace {

// Magic bytes, which end in the format version. Change the version whenever the format of a record changes.
constexpr std::array<char, 8> kMagic{'L', 'O', 'D', 'E', 'T', 'L', '0', '1'};
constexpr uint64_t kMaxTableBytes = 1 << 26;

/// Last bytes of the file. Before it lie the payloads and records, then the table of the nodes' places.
struct Footer {
  std::array<char, 8> magic = kMagic;
  uint64_t table_offset = 0;
  RecordPlace root;
  uint64_t root_triangles = 0;
  uint64_t checksum = 0;  ///< checksum of all bytes before this member
};
constexpr size_t kCheckedOfFooter = offsetof(Footer, checksum);

bool isSound(const Spool& spool, uint64_t end, const Footer& footer) {
  RunningChecksum checksum;
  SpoolCursor cursor(spool, 0, end + kCheckedOfFooter);
  while (!cursor.atEnd()) checksum.add(cursor.take(1 << 20));
  return checksum.value() == footer.checksum;
}

bool isInside(RecordPlace place, uint64_t end) {
  return place.offset <= end && place.bytes <= end - place.offset;
}

}  // namespace

std::string temporaryEnding() {
  std::array<char, 65> host{};
  ::gethostname(host.data(), host.size() - 1);
  return std::string(".new-") + host.data() + "-" + std::to_string(::getpid());
}

std::optional<TreeletFile> TreeletFile::open(const std::filesystem::path& path) {
  std::error_code error;
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error || size < sizeof(Footer)) return std::nullopt;
  const Spool spool = Spool::forReading(path, size);
  Footer footer;
  const uint64_t end = size - sizeof(Footer);
  spool.readAt(end, std::as_writable_bytes(std::span(&footer, 1)));
  if (footer.magic != kMagic || footer.table_offset > end || end - footer.table_offset > kMaxTableBytes ||
      !isInside(footer.root, end) || footer.root_triangles > std::numeric_limits<uint32_t>::max() ||
      !isSound(spool, end, footer))
    return std::nullopt;
  TreeletFile file;
  file.path_ = path;
  file.bytes_ = size;
  file.root_ = footer.root;
  file.root_triangles_ = static_cast<uint32_t>(footer.root_triangles);
  file.nodes_.resize((end - footer.table_offset) / sizeof(NodePlace));
  spool.readAt(footer.table_offset, std::as_writable_bytes(std::span(file.nodes_)));
  for (const NodePlace& node : file.nodes_)
    if (!isInside(node.record, end)) return std::nullopt;
  return file;
}

BuiltNode TreeletFile::readRoot() const {
  const std::vector<std::byte> bytes = TreeletReader().read(path_, root_);
  RecordReader record(bytes);
  return getBuiltNode(record);
}

TreeletWriter::TreeletWriter(std::filesystem::path path)
    : temporary_path_(path.string() + temporaryEnding()), spool_(TemporaryFile{temporary_path_, false}) {
  file_.path_ = std::move(path);
}

RecordPlace TreeletWriter::append(std::span<const std::byte> bytes) {
  const RecordPlace place{spool_.size(), bytes.size()};
  spool_.append(bytes);
  checksum_.add(bytes);
  return place;
}

void TreeletWriter::add(const Node& node, std::span<const std::vector<std::byte>> payloads) {
  std::vector<PayloadPlace> places;
  for (const std::vector<std::byte>& payload : payloads)
    places.push_back({append(payload).offset, static_cast<uint32_t>(payload.size())});
  RecordWriter record;
  putFinishedNode(record, node, places);
  file_.nodes_.push_back({node.key, append(record.bytes())});
  spool_.flush();  // many treelets can be open at the same time, so none of them keeps a buffer
}

TreeletFile TreeletWriter::finish(const BuiltNode& root) {
  RecordWriter record;
  putBuiltNode(record, root);
  file_.root_ = append(record.bytes());
  file_.root_triangles_ = static_cast<uint32_t>(root.coarsest.triangles.size());
  Footer footer;
  footer.table_offset = append(std::as_bytes(std::span(file_.nodes_))).offset;
  footer.root = file_.root_;
  footer.root_triangles = file_.root_triangles_;
  checksum_.add(std::as_bytes(std::span(&footer, 1)).first(kCheckedOfFooter));
  footer.checksum = checksum_.value();
  spool_.append(std::as_bytes(std::span(&footer, 1)));
  spool_.flush();
  file_.bytes_ = spool_.size();
  if (::rename(temporary_path_.c_str(), file_.path_.c_str()) != 0)
    throw Error(ErrorCode::kIo,
                "cannot rename temporary file " + temporary_path_.string() + ": " + fileErrorInWords(errno));
  return std::move(file_);
}

std::vector<std::byte> TreeletReader::read(const std::filesystem::path& path, RecordPlace place) {
  if (!spool_ || path_ != path) {
    spool_.reset();
    path_ = path;
    spool_.emplace(Spool::forReading(path_, place.offset + place.bytes));
  }
  std::vector<std::byte> bytes(place.bytes);
  spool_->readAt(place.offset, bytes);
  return bytes;
}

}  // namespace lode::ingest
