#include "server/ingest/partition/border_table.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>

#include "common/error.h"
#include "common/limits.h"

namespace lode::ingest {
namespace {

constexpr uint64_t kFansPerReport = 1 << 16;

}  // namespace

void refuseTooManyLocked(const std::array<uint64_t, 8>& locked, const std::filesystem::path& input) {
  const uint64_t most = *std::ranges::max_element(locked);
  if (most <= kMaxLodTriangles) return;
  throw Error(ErrorCode::kLimit, input.string() + ": a node below the root would lock " +
                                     std::to_string(most) + " vertices, and an LOD has at most " +
                                     std::to_string(kMaxLodTriangles) +
                                     " triangles; build several stores and show them as a scene");
}

BorderTable::BorderTable(const TemporaryFolder& folder, uint64_t memory_bytes)
    : by_position_(std::make_unique<RecordSorter>(sizeof(ListedFan), memory_bytes / 2,
                                                  folder.file("border-by-position"))),
      by_leaf_(std::make_unique<RecordSorter>(sizeof(BorderVertex), memory_bytes / 2,
                                              folder.file("border-by-leaf"))),
      joined_(folder.lastingFile(kFile)) {}

BorderTable::BorderTable(const TemporaryFolder& folder, RecordReader& record)
    : joined_(Spool::forReading(folder.path() / kFile, record.get<uint64_t>())),
      first_of_leaf_(record.getAll<uint64_t>()),
      digests_(record.getAll<Digest>()),
      locked_below_root_(record.get<std::array<uint64_t, 8>>()) {
  if (first_of_leaf_.empty() || digests_.size() != leafCount() ||
      !std::is_sorted(first_of_leaf_.begin(), first_of_leaf_.end()) ||
      first_of_leaf_.back() != joined_.size() / sizeof(BorderVertex)) {
    throw Error(ErrorCode::kFormat, "the build's journal has a damaged border table; build without --resume");
  }
}

void BorderTable::save(RecordWriter& record) const {
  joined_.sync();
  record.put(joined_.size());
  record.putAll(first_of_leaf_);
  record.putAll(digests_);
  record.put(locked_below_root_);
}

std::span<const BorderVertex> sharedAt(std::span<const BorderVertex> border, PositionCode position) noexcept {
  const auto begin = std::ranges::lower_bound(border, position, {}, &BorderVertex::position);
  return {begin, std::ranges::upper_bound(begin, border.end(), position, {}, &BorderVertex::position)};
}

void BorderTable::add(PositionCode position, const ListedFan& fan) {
  by_position_->push(position.value, std::as_bytes(std::span(&fan, 1)));
}

void BorderTable::join(std::span<const NodeKey> leaves, const CreaseAngle& crease,
                       const RecordSorter::Progress& progress) {
  std::vector<ListedFan> sharing;
  PositionCode position;
  NodeKey ancestor;
  const auto addToLeaves = [&] {
    if (!sharing.empty() && sharing.front().leaf != sharing.back().leaf) {
      const std::vector<uint16_t> normals = joinFans(sharing, crease);
      BorderVertex vertex;
      std::memset(static_cast<void*>(&vertex), 0, sizeof(vertex));
      vertex.position = position;
      vertex.lca_depth = static_cast<uint8_t>(ancestor.depth());
      if (ancestor == kRootKey) countBelowRoot(leaves, sharing);
      uint32_t fans = 0;  // number of the leaf's fans so far
      for (size_t i = 0; i < sharing.size(); ++i) {
        if (i > 0 && sharing[i].leaf != sharing[i - 1].leaf) fans = 0;
        if (sharing[i].fan != fans) continue;  // another entry of an earlier fan, see ListedFan
        vertex.normal = normals[i];
        vertex.fan = static_cast<uint16_t>(fans++);
        by_leaf_->push(sharing[i].leaf, std::as_bytes(std::span(&vertex, 1)));
      }
    }
    sharing.clear();
  };

  const uint64_t listings = by_position_->size();
  uint64_t done = 0;
  const auto advance = [&] {
    if (progress && ++done % kFansPerReport == 0) progress(done, 2 * listings);
  };
  by_position_->finish();
  while (const auto record = by_position_->next()) {
    ListedFan listed;
    std::memcpy(static_cast<void*>(&listed), record->bytes.data(), sizeof(listed));
    if (PositionCode{record->key} != position) addToLeaves();
    position = PositionCode{record->key};
    ancestor = sharing.empty() ? leaves[listed.leaf] : commonAncestor(ancestor, leaves[listed.leaf]);
    sharing.push_back(listed);
    advance();
  }
  addToLeaves();

  temporary_bytes_ += by_position_->temporaryBytes();
  by_position_.reset();

  appendByLeaf(leaves.size(), advance);
}

/// Writes the shared vertices of all leaves to the table's file, in the order of the leaves.
void BorderTable::appendByLeaf(size_t leaves, const std::function<void()>& advance) {
  by_leaf_->finish();
  first_of_leaf_.assign(1, 0);
  digests_.clear();
  std::vector<std::byte> vertices;  // shared vertices of the current leaf
  const auto endLeaf = [&] {
    first_of_leaf_.push_back(first_of_leaf_.back() + vertices.size() / sizeof(BorderVertex));
    digests_.push_back(digestOf(vertices));
    joined_.append(vertices);
    vertices.clear();
  };
  while (const auto record = by_leaf_->next()) {
    while (digests_.size() < record->key) endLeaf();
    vertices.insert(vertices.end(), record->bytes.begin(), record->bytes.end());
    advance();
  }
  while (digests_.size() < leaves) endLeaf();
  temporary_bytes_ += by_leaf_->temporaryBytes();
  by_leaf_.reset();
  joined_.flush();
}

/// Counts a position in locked_below_root_ once for each child of the root that has a leaf there.
/// @param sharing  all fans at one position, sorted by leaf.
void BorderTable::countBelowRoot(std::span<const NodeKey> leaves, std::span<const ListedFan> sharing) {
  std::optional<unsigned> last;
  for (const ListedFan& listed : sharing) {
    const unsigned octant = leaves[listed.leaf].ancestorAt(1).octant();
    if (octant != last) ++locked_below_root_[octant];
    last = octant;
  }
}

std::vector<BorderVertex> BorderTable::read(uint32_t leaf) const {
  std::vector<BorderVertex> vertices(first_of_leaf_[leaf + 1] - first_of_leaf_[leaf]);
  joined_.readAt(first_of_leaf_[leaf] * sizeof(BorderVertex), std::as_writable_bytes(std::span(vertices)));
  return vertices;
}

}  // namespace lode::ingest
