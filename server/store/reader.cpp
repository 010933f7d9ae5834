#include "server/store/reader.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"
#include "common/io/file_io.h"
#include "common/io/foreign_file.h"
#include "common/limits.h"
#include "server/store/format.h"
#include "server/store/node_tree.h"

namespace lode::store {
namespace {

/// Largest number of bytes of neighbouring blobs that one read fetches while a store is opened.
/// Bounds the memory that opening needs beside the index itself.
constexpr size_t kMaxRunBytes = 4u << 20;
static_assert(kMaxRunBytes >= kMaxPageBytes);

[[noreturn]] void failReading(const std::string& what) { throw Error(ErrorCode::kFormat, what); }

/// An open file; closed on destruction.
class File {
 public:
  /// Opens a file. Does not block if the file is a pipe, which cannot be a store.
  explicit File(const std::filesystem::path& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    if (descriptor_ < 0)
      throw Error(ErrorCode::kIo, std::string("cannot be opened: ") + std::strerror(errno));
  }
  ~File() { ::close(descriptor_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  int descriptor() const noexcept { return descriptor_; }

  uint64_t size() const {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0)
      throw Error(ErrorCode::kIo, std::string("cannot be examined: ") + std::strerror(errno));
    if (S_ISDIR(status.st_mode)) throw Error(ErrorCode::kIo, "is a directory: give a .lode file");
    if (!S_ISREG(status.st_mode)) throw Error(ErrorCode::kIo, "is not a regular file: give a .lode file");
    return static_cast<uint64_t>(status.st_size);
  }

  void readAt(uint64_t offset, std::span<std::byte> into) const {
    const std::optional<size_t> got = lode::readAt(descriptor_, offset, into);
    if (!got)
      throw Error(ErrorCode::kIo,
                  "cannot be read at byte " + std::to_string(offset) + ": " + std::strerror(errno));
    if (*got < into.size())
      failReading("ends at byte " + std::to_string(offset + *got) + " while it is being read");
  }

 private:
  int descriptor_;
};

}  // namespace

struct Reader::State {
  explicit State(const std::filesystem::path& file_path) : path(file_path), file(file_path) {}

  /// First bytes of the file; `bytes` has zeros after the end of a shorter file.
  struct Head {
    std::array<std::byte, kForeignHeadBytes> bytes{};
    size_t size = 0;
  };
  struct PageRef {
    NodeKey owner;
    uint32_t blob = 0;
  };

  void open();
  Head readHead(uint64_t file_bytes) const;
  void refuseForeignFile(const Head& head, uint64_t file_bytes) const;
  void readIndex();
  void readHierarchy();
  void addPage(const PageRef& ref, std::span<const std::byte> bytes, std::vector<PageRef>& below);
  void checkPageRef(const PageRef& ref, std::vector<bool>& seen) const;
  void readTextures();
  void checkSummary(const HierarchyTotals& totals) const;
  void checkRefs() const;
  void resolve(const BlobRef& ref, const std::string& user) const;
  void checkBlob(uint32_t number, std::span<const std::byte> bytes) const;
  std::vector<std::byte> readBlob(uint32_t number) const;
  template <typename Action>
  void readPages(std::span<const PageRef> pages, Action&& action) const;

  std::filesystem::path path;
  File file;
  ModelSummary summary;
  std::vector<BlobEntry> blobs;
  std::vector<Node> nodes;
  TextureSet textures;
};

namespace {

/// Runs an action. Adds the file name to the action's errors, and a remedy if the content is damaged.
template <typename Action>
auto namingFile(const std::filesystem::path& path, Action&& action) {
  try {
    return action();
  } catch (const Error& error) {
    const std::string what = error.what();
    const bool damaged = error.code() == ErrorCode::kFormat || error.code() == ErrorCode::kLimit;
    const bool names_remedy = what.find(';') != what.npos;
    throw Error(error.code(), path.string() + ": " + what +
                                  (damaged && !names_remedy ? "; copy it again or rebuild it" : ""));
  }
}

}  // namespace

void Reader::State::open() {
  readIndex();
  readHierarchy();
  readTextures();
  checkSummary(checkHierarchy(nodes));
  checkRefs();
}

Reader::State::Head Reader::State::readHead(uint64_t file_bytes) const {
  Head head;
  head.size = std::min<uint64_t>(file_bytes, head.bytes.size());
  file.readAt(0, std::span(head.bytes).first(head.size));
  return head;
}

/// Refuses files of other formats, and stores that are too short for a header. @throws Error kInput, kFormat.
void Reader::State::refuseForeignFile(const Head& head, uint64_t file_bytes) const {
  const std::string_view text(reinterpret_cast<const char*>(head.bytes.data()), head.size);
  if (const auto foreign = foreignFileInWords(path, text)) throw Error(ErrorCode::kInput, *foreign);
  if (file_bytes < kHeaderBytes + kFooterBytes && beginsAsStore(std::span(head.bytes).first(head.size)))
    failReading("truncated: it has only " + std::to_string(file_bytes) + " bytes");
}

/// Reads the header with the first read, and the blob table with the footer behind it with the second.
void Reader::State::readIndex() {
  const uint64_t file_bytes = file.size();
  const Head head = readHead(file_bytes);
  refuseForeignFile(head, file_bytes);
  const auto header_bytes = std::span(head.bytes).first<kHeaderBytes>();
  const FileHeader header = decodeHeader(header_bytes, file_bytes);
  std::vector<std::byte> tail(file_bytes - header.table_offset);
  file.readAt(header.table_offset, tail);
  checkFooter(std::span(tail).last<kFooterBytes>(), header_bytes);
  const auto table = std::span<const std::byte>(tail).first(size_t{header.blobs} * kTableEntryBytes);
  uint64_t offset = kHeaderBytes;
  for (const TableEntry& entry : decodeTable(table, header)) {
    blobs.push_back({offset, entry.bytes, entry.checksum, entry.digest});
    offset += entry.bytes;
  }
  if (computeBuildId(header, table) != header.summary.build_id)
    failReading("header: the build id is not the hash of the index");
  summary = header.summary;
  summary.name = path.stem().string();
  const BlobEntry& root = blobs[summary.root_page.number - 1];
  summary.root_page = {summary.root_page.number, root.bytes, root.digest};
  if (!summary.textures) return;
  const BlobEntry& textures_blob = blobs[summary.textures.number - 1];
  summary.textures = {summary.textures.number, textures_blob.bytes, textures_blob.digest};
}

/// Reads all pages, one level of pages after the other from the root down. Terminates for any file, because a
/// second reference to a page is an error.
void Reader::State::readHierarchy() {
  std::vector<bool> seen(blobs.size());
  std::vector<PageRef> level{{kRootKey, summary.root_page.number}};
  while (!level.empty()) {
    for (const PageRef& page : level) checkPageRef(page, seen);
    std::ranges::sort(level, {}, &PageRef::blob);
    std::vector<PageRef> below;
    readPages(level,
              [&](const PageRef& page, std::span<const std::byte> bytes) { addPage(page, bytes, below); });
    level = std::move(below);
  }
  std::sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) { return a.key < b.key; });
}

void Reader::State::checkPageRef(const PageRef& ref, std::vector<bool>& seen) const {
  if (seen[ref.blob - 1]) failReading("blob " + std::to_string(ref.blob) + ": two nodes refer to this page");
  seen[ref.blob - 1] = true;
  if (blobs[ref.blob - 1].bytes > kMaxPageBytes)
    throw Error(ErrorCode::kLimit, "blob " + std::to_string(ref.blob) + ": a page larger than the limit of " +
                                       std::to_string(kMaxPageBytes) + " bytes");
}

/// Adds the nodes of a page. @param below  receives the pages to which the nodes refer.
void Reader::State::addPage(const PageRef& ref, std::span<const std::byte> bytes,
                            std::vector<PageRef>& below) {
  HierarchyPage page = decodePage(bytes, ref.owner, ref.owner == kRootKey);
  for (Node& node : page.nodes) {
    if (pageOwner(node.key) != ref.owner)
      failReading("node " + describeKey(node.key) + ": is in the wrong page");
    if (ownsPage(node) != static_cast<bool>(node.child_page))
      failReading("node " + describeKey(node.key) + ": has an unnecessary page, or its page is missing");
    if (node.child_page) {
      resolve(node.child_page, "node " + describeKey(node.key));
      below.push_back({node.key, node.child_page.number});
    }
    nodes.push_back(std::move(node));
  }
  if (nodes.size() > summary.nodes) failReading("the pages hold more nodes than the header says");
}

/// Reads pages and calls `action` with the bytes of each. Reads neighbouring blobs together, because on
/// network storage a read costs a round trip.
/// @param pages  pages in the order of their blobs, each at most kMaxPageBytes.
template <typename Action>
void Reader::State::readPages(std::span<const PageRef> pages, Action&& action) const {
  std::vector<std::byte> run;
  for (size_t begin = 0, end = 0; begin < pages.size(); begin = end) {
    const BlobEntry& first = blobs[pages[begin].blob - 1];
    size_t run_bytes = 0;
    for (; end < pages.size(); ++end) {
      const BlobEntry& next = blobs[pages[end].blob - 1];
      if (next.offset != first.offset + run_bytes || run_bytes + next.bytes > kMaxRunBytes) break;
      run_bytes += next.bytes;
    }
    run.resize(run_bytes);
    file.readAt(first.offset, run);
    auto rest = std::span<const std::byte>(run);
    for (const PageRef& page : pages.subspan(begin, end - begin)) {
      const auto bytes = rest.first(blobs[page.blob - 1].bytes);
      checkBlob(page.blob, bytes);
      action(page, bytes);
      rest = rest.subspan(bytes.size());
    }
  }
}

void Reader::State::readTextures() {
  if (!summary.textures) return;
  if (summary.textures.bytes > kMaxTextureSetBytes)
    throw Error(ErrorCode::kLimit, "blob " + std::to_string(summary.textures.number) +
                                       ": a texture set larger than the limit of " +
                                       std::to_string(kMaxTextureSetBytes) + " bytes");
  textures = decodeTextureSet(readBlob(summary.textures.number));
}

void Reader::State::checkSummary(const HierarchyTotals& totals) const {
  if (nodes.size() != summary.nodes || totals.triangles != summary.triangles ||
      totals.stored_triangles != summary.stored_triangles || totals.payloads != summary.payloads ||
      totals.depth != summary.depth)
    failReading("the header's counts do not match the nodes");
  if (nodes[0].box != summary.box) failReading("the header's box does not match the root's");
  if (nodes[0].lods.back().error_model != summary.max_error_model)
    failReading("the header's error does not match the root's coarsest LOD");
}

/// Checks that every blob of the file is used, and used in only one way, such as a payload or a tile.
void Reader::State::checkRefs() const {
  enum Use : uint8_t { kNone, kPage, kPayload, kTextures, kTile };
  std::vector<Use> uses(blobs.size(), kNone);
  uses[summary.root_page.number - 1] = kPage;
  for (const Node& node : nodes)
    if (node.child_page) uses[node.child_page.number - 1] = kPage;
  const auto claim = [&](const BlobRef& ref, Use use, const std::string& user) {
    Use& known = uses[ref.number - 1];
    if (known != kNone && known != use)
      failReading(user + ": refers to blob " + std::to_string(ref.number) + ", which has another use");
    known = use;
  };
  if (summary.textures) claim(summary.textures, kTextures, "header");
  for (const Texture& texture : textures.textures)
    for (const BlobRef& tile : texture.tiles) {
      resolve(tile, "texture " + texture.name);
      claim(tile, kTile, "texture " + texture.name);
    }
  for (const Node& node : nodes)
    for (const Lod& lod : node.lods) {
      if (!lod.payload) continue;
      resolve(lod.payload, "node " + describeKey(node.key));
      claim(lod.payload, kPayload, "node " + describeKey(node.key));
    }
  if (const auto unused = std::find(uses.begin(), uses.end(), kNone); unused != uses.end())
    failReading("blob " + std::to_string(unused - uses.begin() + 1) + ": not used");
}

void Reader::State::resolve(const BlobRef& ref, const std::string& user) const {
  if (ref.number == 0 || ref.number > blobs.size()) failReading(user + ": refers to a missing blob");
  const BlobEntry& entry = blobs[ref.number - 1];
  if (entry.bytes != ref.bytes || entry.digest != ref.digest)
    failReading(user + ": size or digest of blob " + std::to_string(ref.number) +
                " does not match the blob table");
}

void Reader::State::checkBlob(uint32_t number, std::span<const std::byte> bytes) const {
  const BlobEntry& entry = blobs[number - 1];
  if (checksum(bytes) != entry.checksum)
    failReading("blob " + std::to_string(number) + " at byte " + std::to_string(entry.offset) +
                ": the checksum does not match");
}

std::vector<std::byte> Reader::State::readBlob(uint32_t number) const {
  const BlobEntry& entry = blobs[number - 1];
  std::vector<std::byte> bytes(entry.bytes);
  file.readAt(entry.offset, bytes);
  checkBlob(number, bytes);
  return bytes;
}

Reader::Reader(const std::filesystem::path& path) {
  namingFile(path, [&] {
    state_ = std::make_unique<State>(path);
    state_->open();
  });
}

Reader::~Reader() = default;
Reader::Reader(Reader&&) noexcept = default;

const ModelSummary& Reader::summary() const noexcept { return state_->summary; }
const std::filesystem::path& Reader::path() const noexcept { return state_->path; }
std::span<const Node> Reader::nodes() const noexcept { return state_->nodes; }
uint32_t Reader::blobCount() const noexcept { return static_cast<uint32_t>(state_->blobs.size()); }
const TextureSet& Reader::textures() const noexcept { return state_->textures; }
int Reader::fileDescriptor() const noexcept { return state_->file.descriptor(); }

const Node* Reader::find(NodeKey key) const noexcept {
  const auto found = std::lower_bound(state_->nodes.begin(), state_->nodes.end(), key,
                                      [](const Node& node, NodeKey wanted) { return node.key < wanted; });
  return found != state_->nodes.end() && found->key == key ? &*found : nullptr;
}

const BlobEntry& Reader::blob(uint32_t number) const {
  if (number == 0 || number > state_->blobs.size())
    throw Error(ErrorCode::kFormat, state_->path.string() + ": there is no blob " + std::to_string(number) +
                                        " in this store: ask for 1 to " + std::to_string(blobCount()));
  return state_->blobs[number - 1];
}

std::vector<std::byte> Reader::readBlob(uint32_t number) const {
  blob(number);
  return namingFile(state_->path, [&] { return state_->readBlob(number); });
}

}  // namespace lode::store
