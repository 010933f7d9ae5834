#include "server/store/writer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>

#include "common/error.h"
#include "common/limits.h"
#include "common/release_storage.h"
#include "server/store/node_tree.h"

namespace lode::store {

size_t Writer::NameHash::operator()(const Digest& name) const noexcept {
  size_t hash;
  std::memcpy(&hash, name.bytes.data(), sizeof hash);
  return hash;
}

Writer::Writer(const std::filesystem::path& path, const std::filesystem::path& temporary)
    : file_(path, temporary), path_(path) {
  file_.write(std::array<std::byte, kHeaderBytes>{});
}

BlobRef Writer::addBlob(std::span<const std::byte> bytes) {
  if (bytes.empty()) return {};
  const Digest name = digestOf(bytes);
  if (const auto known = numbers_.find(name); known != numbers_.end())
    return {known->second, entries_[known->second - 1].bytes, name};
  const BlobRef ref = append(bytes, name);
  numbers_.emplace(name, ref.number);
  return ref;
}

BlobRef Writer::append(std::span<const std::byte> bytes, const Digest& name) {
  if (bytes.size() > kMaxBlobBytes)
    throw Error(ErrorCode::kLimit, path_.string() + ": a blob of " + std::to_string(bytes.size()) +
                                       " bytes, the limit is " + std::to_string(kMaxBlobBytes));
  if (entries_.size() == std::numeric_limits<uint32_t>::max())
    throw Error(ErrorCode::kLimit, path_.string() + ": too many blobs for one store");
  file_.write(bytes);
  entries_.push_back({static_cast<uint32_t>(bytes.size()), checksum(bytes), name});
  return {static_cast<uint32_t>(entries_.size()), entries_.back().bytes, name};
}

void Writer::addTextures(const TextureSet& textures) {
  for (const Texture& texture : textures.textures)
    for (const BlobRef& tile : texture.tiles) {
      if (!wasAdded(tile))
        throw Error(ErrorCode::kFormat, "texture " + texture.name + ": refers to a blob that was not added");
      tiles_.push_back(tile.number);
    }
  textures_ = addBlob(encodeTextureSet(textures));
}

bool Writer::wasAdded(const BlobRef& ref) const {
  return ref && ref.number <= entries_.size() && entries_[ref.number - 1].bytes == ref.bytes &&
         entries_[ref.number - 1].digest == ref.digest;
}

/// Checks that addBlob() has added every payload and that every added blob is used.
void Writer::checkUse(std::span<const Node> nodes) const {
  std::vector<bool> used(entries_.size());
  if (textures_) used[textures_.number - 1] = true;
  for (const uint32_t tile : tiles_) used[tile - 1] = true;
  for (const Node& node : nodes) {
    if (node.child_page)
      throw Error(ErrorCode::kFormat, "node " + describeKey(node.key) + ": has a page already");
    for (const Lod& lod : node.lods) {
      const BlobRef& ref = lod.payload;
      if (!ref) continue;
      if (!wasAdded(ref))
        throw Error(ErrorCode::kFormat,
                    "node " + describeKey(node.key) + ": refers to a blob that was not added");
      used[ref.number - 1] = true;
    }
  }
  if (const auto unused = std::find(used.begin(), used.end(), false); unused != used.end())
    throw Error(ErrorCode::kFormat,
                path_.string() + ": blob " + std::to_string(unused - used.begin() + 1) + " is not used");
}

/// Writes all pages, coarse pages first. A page contains the numbers, sizes and digests of the pages below
/// it, so all pages are numbered first and then encoded from last to first.
/// @return the root's page.
BlobRef Writer::writePages(std::vector<Node> nodes) {
  std::vector<PagePlan> plans = splitIntoPages(std::move(nodes));
  if (entries_.size() + plans.size() > std::numeric_limits<uint32_t>::max())
    throw Error(ErrorCode::kLimit, path_.string() + ": too many blobs for one store");
  const auto first_number = static_cast<uint32_t>(entries_.size() + 1);
  std::vector<std::vector<std::byte>> encoded(plans.size());
  std::vector<Digest> names(plans.size());
  for (size_t i = plans.size(); i-- > 0;) {
    for (Node& node : plans[i].page.nodes) {
      if (!ownsPage(node)) continue;
      const auto below = std::lower_bound(plans.begin(), plans.end(), node.key,
                                          [](const PagePlan& plan, NodeKey key) { return plan.owner < key; });
      const auto index = static_cast<uint32_t>(below - plans.begin());
      node.child_page = {first_number + index, static_cast<uint32_t>(encoded[index].size()), names[index]};
    }
    encoded[i] = encodePage(plans[i].page);
    names[i] = digestOf(encoded[i]);
    releaseStorage(plans[i].page.nodes);
  }
  BlobRef root = append(encoded[0], names[0]);
  for (size_t i = 1; i < encoded.size(); ++i) append(encoded[i], names[i]);
  return root;
}

ModelSummary Writer::finish(ModelSummary summary, std::vector<Node> nodes) {
  const HierarchyTotals totals = checkHierarchy(nodes);
  checkUse(nodes);
  summary.name = path_.stem().string();
  summary.box = nodes[0].box;
  summary.triangles = totals.triangles;
  summary.stored_triangles = totals.stored_triangles;
  summary.nodes = nodes.size();
  summary.payloads = totals.payloads;
  summary.depth = totals.depth;
  summary.max_error_model = nodes[0].lods.back().error_model;
  summary.textures = textures_;
  summary.root_page = writePages(std::move(nodes));

  const std::vector<std::byte> table = encodeTable(entries_);
  FileHeader header;
  header.table_offset = file_.size();
  header.blobs = static_cast<uint32_t>(entries_.size());
  header.table_checksum = checksum(table);
  summary.bytes = header.table_offset + table.size() + kFooterBytes;
  header.summary = summary;
  header.summary.build_id = summary.build_id = computeBuildId(header, table);
  const auto header_bytes = encodeHeader(header);
  decodeHeader(header_bytes, summary.bytes);
  file_.write(table);
  file_.write(encodeFooter(header_bytes));
  file_.writeAt(0, header_bytes);
  file_.commit();
  return summary;
}

}  // namespace lode::store
