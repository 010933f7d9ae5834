#include "common/codec/hierarchy_page.h"

#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "common/error.h"
#include "common/limits.h"

namespace lode {
namespace {

constexpr uint8_t kPageVersion = 2;

// ---- writing

class PageWriter {
 public:
  std::vector<std::byte> take() { return std::move(bytes_); }

  void fixed(uint64_t value, int width) {
    for (int i = 0; i < width; ++i) bytes_.push_back(static_cast<std::byte>(value >> 8 * i & 255));
  }
  void varint(uint64_t value) {
    for (; value >= 128; value >>= 7) bytes_.push_back(static_cast<std::byte>(value | 128));
    bytes_.push_back(static_cast<std::byte>(value));
  }
  void real(float value) { fixed(std::bit_cast<uint32_t>(value), 4); }
  void blob(const BlobRef& blob) {
    varint(blob.number);
    if (!blob) return;
    varint(blob.bytes);
    bytes_.insert(bytes_.end(), blob.digest.bytes.begin(), blob.digest.bytes.end());
  }

 private:
  std::vector<std::byte> bytes_;
};

void writeLod(PageWriter& out, const Lod& lod) {
  out.blob(lod.payload);
  if (lod.payload) {
    out.varint(lod.triangles);
    out.varint(lod.vertices);
    out.varint(lod.locked);
  }
  out.real(lod.error_model);
  out.real(lod.appearance_error_model);
}

void writeNode(PageWriter& out, const Node& node) {
  out.varint(node.key.value);
  out.fixed(packPosition(node.box.min).value, 8);
  out.fixed(packPosition(node.box.max).value, 8);
  out.fixed(node.child_mask, 1);
  out.blob(node.child_page);
  out.varint(node.lods.size());
  out.varint(node.far_lods);
  for (const Lod& lod : node.lods) writeLod(out, lod);
}

// ---- reading

[[noreturn]] void refusePage(const std::string& why) {
  throw Error(ErrorCode::kFormat, "damaged hierarchy page: " + why + "; fetch it again or rebuild the store");
}

[[noreturn]] void refuseNode(NodeKey key, const std::string& why) {
  refusePage("node " + std::to_string(key.value) + " " + why);
}

class PageReader {
 public:
  explicit PageReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  bool atEnd() const noexcept { return bytes_.empty(); }

  uint64_t fixed(size_t width) {
    uint64_t value = 0;
    const auto bytes = take(width);
    for (size_t i = 0; i < width; ++i) value |= std::to_integer<uint64_t>(bytes[i]) << 8 * i;
    return value;
  }
  // Accepts only the shortest form of a number, so that equal pages have equal bytes.
  uint64_t varint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const uint64_t byte = fixed(1);
      if (shift == 63 && byte > 1) break;
      value |= (byte & 127) << shift;
      if (byte >= 128) continue;
      if (byte == 0 && shift > 0) break;
      return value;
    }
    refusePage("a number is not in its shortest form");
  }
  uint32_t count(uint32_t most, const char* what) {
    const uint64_t value = varint();
    if (value > most)
      throw Error(ErrorCode::kLimit, "damaged hierarchy page: it announces " + std::to_string(value) + " " +
                                         what + " where " + std::to_string(most) + " are allowed");
    return static_cast<uint32_t>(value);
  }
  float error() {
    const float value = std::bit_cast<float>(static_cast<uint32_t>(fixed(4)));
    if (!std::isfinite(value) || std::signbit(value)) refusePage("an error is negative or not finite");
    return value;
  }
  BlobRef blob(uint32_t most_bytes) {
    BlobRef blob;
    blob.number = count(UINT32_MAX, "blobs");
    if (!blob) return blob;
    blob.bytes = count(most_bytes, "bytes of a blob");
    if (blob.bytes == 0) refusePage("a blob has no bytes");
    const auto name = take(blob.digest.bytes.size());
    std::copy(name.begin(), name.end(), blob.digest.bytes.begin());
    return blob;
  }
  LatticeBox box() {
    const uint64_t min = fixed(8), max = fixed(8);
    if ((min | max) >> 3 * kLatticeBits != 0) refusePage("a box is off the lattice");
    const LatticeBox box{unpackPosition({min}), unpackPosition({max})};
    if (box != LatticeBox() && glm::any(glm::greaterThan(box.min, box.max)))
      refusePage("a box has its minimum above its maximum");
    return box;
  }

 private:
  std::span<const std::byte> take(size_t length) {
    if (length > bytes_.size()) refusePage("it is cut off");
    const auto taken = bytes_.first(length);
    bytes_ = bytes_.subspan(length);
    return taken;
  }

  std::span<const std::byte> bytes_;
};

Lod readLod(PageReader& in) {
  Lod lod;
  lod.payload = in.blob(kMaxBlobBytes);
  if (lod.payload) {
    lod.triangles = in.count(kMaxLodTriangles, "triangles");
    lod.vertices = in.count(kMaxLodVertices, "vertices");
    lod.locked = in.count(kMaxLodVertices, "locked vertices");
    if (lod.triangles == 0) refusePage("a payload has no triangles");
    if (lod.vertices < 3 || lod.vertices > 3 * lod.triangles || lod.locked > lod.vertices)
      refusePage("a payload's vertices do not fit its triangles");
  }
  lod.error_model = in.error();
  lod.appearance_error_model = in.error();
  return lod;
}

bool fallsFrom(const Lod& finer, const Lod& coarser) {
  return coarser.error_model < finer.error_model ||
         coarser.appearance_error_model < finer.appearance_error_model;
}

Node readNode(PageReader& in) {
  Node node;
  node.key.value = in.varint();
  if (!node.key.valid())
    refusePage("it names a node " + std::to_string(node.key.value) + " that cannot exist");
  node.box = in.box();
  node.child_mask = static_cast<uint8_t>(in.fixed(1));
  node.child_page = in.blob(kMaxPageBytes);
  const uint32_t lods = in.count(kMaxLods, "LODs of a node");
  if (lods == 0) refuseNode(node.key, "has no LOD");
  node.far_lods = in.count(lods - 1, "far LODs of a node");
  if (node.far_lods > 0 && (node.isLeaf() || node.key == kRootKey))
    refuseNode(node.key, "has far LODs where none can be");
  node.lods.reserve(lods);
  for (uint32_t i = 0; i < lods; ++i) {
    node.lods.push_back(readLod(in));
    const Lod& lod = node.lods.back();
    if (i > 0 && fallsFrom(node.lods[i - 1], lod))
      refuseNode(node.key, "has a coarser LOD with a smaller error");
    if (lod.triangles > 0 && node.box.empty()) refuseNode(node.key, "has triangles but no box");
  }
  return node;
}

// Checks the tree in one page: the order of its nodes, and the parent, children, box and errors of each node.
class TreeCheck {
 public:
  TreeCheck(const HierarchyPage& page, NodeKey owner, bool is_root_page)
      : nodes_(page.nodes), owner_(owner), is_root_page_(is_root_page) {}

  void run() {
    for (size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      if (i > 0 && node.key <= nodes_[i - 1].key) refuseNode(node.key, "is out of order");
      const int level = node.key.depth() - owner_.depth();
      if (!owner_.contains(node.key) || level > 2 || (level == 0) != (is_root_page_ && i == 0))
        refuseNode(node.key, "does not belong in it");
      checkParent(i);
      checkChildPage(node, level == 2);
    }
    for (size_t i = 0; i < nodes_.size(); ++i)
      if (!nodes_[i].child_page && nodes_[i].child_mask != seen_[i])
        refuseNode(nodes_[i].key, "lacks a child");
  }

 private:
  void checkParent(size_t i) {
    const Node& node = nodes_[i];
    const NodeKey parent_key = node.key.parent();
    if (node.key == owner_ || (!is_root_page_ && parent_key == owner_)) return;
    // Parents are in key order too, so one pass over the nodes finds all parents.
    while (parent_ < i && nodes_[parent_].key < parent_key) ++parent_;
    const Node& parent = nodes_[parent_];
    if (parent.key != parent_key) refuseNode(node.key, "lacks its parent");
    seen_[parent_] = static_cast<uint8_t>(seen_[parent_] | 1 << node.key.octant());
    if (!parent.box.contains(node.box)) refuseNode(node.key, "has a box outside its parent's box");
    if (fallsFrom(node.sourceLod(), parent.lods.front()))
      refuseNode(node.key, "has a larger error than its parent");
  }

  static void checkChildPage(const Node& node, bool deepest) {
    if (deepest && bool(node.child_page) == node.isLeaf())
      refuseNode(node.key, "has children without a page or a page without children");
    if (!deepest && node.child_page) refuseNode(node.key, "has its children both here and elsewhere");
    if (node.key.depth() == kMaxDepth && !node.isLeaf())
      refuseNode(node.key, "has children below the deepest level");
  }

  const std::vector<Node>& nodes_;
  const NodeKey owner_;
  const bool is_root_page_;
  size_t parent_ = 0;
  std::array<uint8_t, kMaxPageNodes> seen_{};  // for each node, mask of its children found so far
};

}  // namespace

std::vector<std::byte> encodePage(const HierarchyPage& page) {
  PageWriter out;
  out.fixed(kPageVersion, 1);
  out.varint(page.nodes.size());
  for (const Node& node : page.nodes) writeNode(out, node);
  std::vector<std::byte> bytes = out.take();
  if (page.nodes.size() > kMaxPageNodes || bytes.size() > kMaxPageBytes)
    throw Error(ErrorCode::kLimit, "a hierarchy page of " + std::to_string(page.nodes.size()) +
                                       " nodes would take " + std::to_string(bytes.size()) +
                                       " bytes: build with fewer LODs");
  return bytes;
}

HierarchyPage decodePage(std::span<const std::byte> bytes, NodeKey owner, bool is_root_page) {
  if (bytes.size() > kMaxPageBytes)
    throw Error(ErrorCode::kLimit,
                "a hierarchy page of " + std::to_string(bytes.size()) + " bytes is above the limit");
  if (!owner.valid() || (is_root_page ? owner != kRootKey : owner.depth() < 2 || owner.depth() % 2 != 0))
    refusePage("no page can hang below node " + std::to_string(owner.value));
  PageReader in(bytes);
  if (in.fixed(1) != kPageVersion) refusePage("its version is unknown");
  const uint32_t nodes = in.count(is_root_page ? kMaxPageNodes : kMaxPageNodes - 1, "nodes");
  if (nodes == 0) refusePage("it is empty");
  HierarchyPage page;
  page.nodes.reserve(nodes);
  for (uint32_t i = 0; i < nodes; ++i) page.nodes.push_back(readNode(in));
  if (!in.atEnd()) refusePage("bytes follow its end");
  TreeCheck(page, owner, is_root_page).run();
  return page;
}

}  // namespace lode
