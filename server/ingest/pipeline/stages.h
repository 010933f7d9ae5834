#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/codec/model_summary.h"
#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/disk/spool.h"
#include "server/ingest/nodes/built_tree.h"
#include "server/ingest/partition/partition.h"
#include "server/ingest/pipeline/build_session.h"
#include "server/ingest/preview/texture_colours.h"
#include "server/ingest/soup/input_images.h"
#include "server/ingest/soup/packed_input.h"
#include "server/ingest/textures/texture_images.h"
#include "server/ingest/textures/textures.h"

/// The stages of a build, in their order; see docs/architecture.md.
namespace lode::ingest {

/// Reads the file into packed vertices and faces, and finds the facts that all later stages need.
class ScanStage final : public Stage {
 public:
  explicit ScanStage(BuildSession& session);

  Work run() override;
  void save(RecordWriter& record) const override;
  void load(RecordReader& record, bool is_used_up) override;

  /// Returns the images that the headers name, or an empty list if the files have no texture coordinates.
  const std::vector<NamedImage>& namedImages() const noexcept { return named_images_; }
  /// Moves out the images that run() found for namedImages(). Returns an empty list after load().
  std::vector<TextureImage> takeImages() { return std::move(images_); }
  /// Writes the preview that the options name. Writes none if a resumed build no longer needs the input.
  /// Warns if the preview needs more than half of the memory.
  void writePreview() const;
  std::unique_ptr<PackedInput> takeInput() { return std::move(input_); }

 private:
  void noteFacts(const PackedInput& input, uint64_t dropped_triangles);
  TextureColours textureColours() const;

  BuildSession& session_;
  std::vector<NamedImage> named_images_;
  std::vector<TextureImage> images_;
  std::unique_ptr<PackedInput> input_;
};

/// Cuts the texture images into encoded tiles.
class TextureStage final : public Stage {
 public:
  TextureStage(BuildSession& session, ScanStage& scan);

  bool isNeeded() const override { return !scan_.namedImages().empty(); }
  Work run() override;
  void save(RecordWriter& record) const override;
  void load(RecordReader& record, bool is_used_up) override;

  const StagedTextures& textures() const noexcept { return textures_; }
  /// Returns the encoded tiles, or null if the model has no textures.
  const Spool* tiles() const noexcept { return tiles_ ? &*tiles_ : nullptr; }

 private:
  BuildSession& session_;
  ScanStage& scan_;
  StagedTextures textures_;
  std::optional<Spool> tiles_;
};

/// Snaps the triangles to the lattice and sorts them by octree cell.
class DereferenceStage final : public Stage {
 public:
  DereferenceStage(BuildSession& session, ScanStage& scan);

  Work run() override;
  /// Returns false if the triangles were sorted in memory. A resumed build then repeats the stage.
  bool isOnDisk() const override { return sorter_->runCount() > 0; }
  void save(RecordWriter& record) const override { sorter_->save(record); }
  void load(RecordReader& record, bool is_used_up) override;

  std::unique_ptr<RecordSorter> takeSorted() { return std::move(sorter_); }

 private:
  void openSorter();
  void sortSoup(const PackedInput& input);
  /// Checks how many triangles are left. @throws Error kInput if no triangle is left, or if most triangles
  /// were lost on the lattice.
  void checkCounts();

  BuildSession& session_;
  ScanStage& scan_;
  std::unique_ptr<RecordSorter> sorter_;
};

/// Cuts the sorted triangles into leaves, welds each leaf, and finds the vertices that leaves share.
class PartitionStage final : public Stage {
 public:
  PartitionStage(BuildSession& session, DereferenceStage& dereference);

  Work run() override;
  void save(RecordWriter& record) const override { partition_->save(record); }
  void load(RecordReader& record, bool is_used_up) override;

  const Partition& partition() const noexcept { return *partition_; }
  void release() noexcept { partition_.reset(); }

 private:
  BuildSession& session_;
  DereferenceStage& dereference_;
  std::optional<Partition> partition_;
};

/// Builds all nodes bottom-up and simplifies, measures and encodes their LODs, except the nodes of treelets
/// that an earlier build or the tasks of this build have finished.
class SimplifyStage final : public Stage {
 public:
  SimplifyStage(BuildSession& session, PartitionStage& partition);

  Work run() override;
  void save(RecordWriter& record) const override { record.putAll(treelets_); }
  void load(RecordReader& record, bool is_used_up) override;

  BuiltTree& tree() noexcept { return tree_; }

 private:
  void warnOfSmallMemory();

  BuildSession& session_;
  PartitionStage& partition_;
  std::vector<Digest> treelets_;  ///< names of all treelets
  BuiltTree tree_;
};

/// Writes the store and renames it to the output's name.
class PackStage final : public Stage {
 public:
  PackStage(BuildSession& session, const TextureStage& textures, SimplifyStage& simplified);

  Work run() override;
  void save(RecordWriter& record) const override { record.put(build_id_); }
  /// Loads nothing, because BuildSession has already compared the store with the recorded build id.
  void load(RecordReader& /*record*/, bool /*is_used_up*/) override {}

 private:
  ModelSummary description() const;

  BuildSession& session_;
  const TextureStage& textures_;
  SimplifyStage& simplified_;
  Digest build_id_;
};

}  // namespace lode::ingest
