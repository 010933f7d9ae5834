#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/ingest/build/recorded_build.h"
#include "server/ingest/disk/build_folder.h"
#include "server/ingest/disk/record_sorter.h"
#include "server/ingest/nodes/tree_builder.h"
#include "server/ingest/partition/partition.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/plan/memory_plan.h"
#include "server/ingest/soup/dereference.h"
#include "server/ingest/soup/lattice_choice.h"
#include "server/ingest/soup/scan.h"
#include "server/ingest/textures/textures.h"

namespace lode::ingest {

/// The stages of one build, to be called in this order, and what one hands to the next. A stage that a
/// resumed build finished before does nothing; one that is finished now is noted in the journal, and then the
/// files that nothing needs any more are removed.
class BuildSteps {
 public:
  /// @param options  complete. @throws Error kInput if the build that is to be resumed was another.
  BuildSteps(const BuildOptions& options, const BuildProgress& progress);

  void scan();
  void textures();
  void dereference();
  void partition();
  void simplify();
  void pack();
  BuildReport report() { return std::move(report_); }

  /// Leaves what is there for a build that is to go on. @return whether there is anything.
  bool keep() noexcept;
  /// Whether what has failed would not have with more memory.
  bool lacksMemory() const noexcept;

 private:
  /// What all stages after the scan need to know.
  struct Facts {
    LatticeChoice choice;
    AttributeSet soup_attributes;
    UvGrid uv_grid;
    uint64_t dropped = 0;  ///< faces, at the scan
  };

  void begin();
  void resume();
  bool isPackedAlready();
  void note(BuildEntry kind, const RecordWriter& record);
  void noteResumed(const char* stage);
  void restoreScan();
  void surveyImages();
  void refuseLargeImages() const;
  void readImages();
  void refuseWarnings() const;
  void warnOfLost();
  void sortSoup();
  NodeBuilder::Settings settings() const;
  ModelSummary summary() const;

  const BuildOptions options_;
  const BuildProgress& progress_;
  const MemoryPlan plan_;
  const BuildIdentity identity_;
  BuildFolder folder_;
  BuildReport report_;
  RecordedBuild recorded_;  ///< what the build that is resumed had finished; emptied as it is used
  std::optional<Journal> journal_;
  std::optional<TemporaryFolder> files_;

  Facts facts_;
  std::vector<std::string> texture_files_;
  std::vector<TextureImage> images_;  ///< of these, once they were looked for
  StagedTextures textures_;
  std::optional<Spool> tiles_;            ///< textures to pack
  std::unique_ptr<PackedInput> input_;    ///< scan to dereference
  std::unique_ptr<RecordSorter> sorter_;  ///< dereference to partition
  DereferenceCounts counts_;
  std::optional<Partition> parts_;        ///< partition to simplify
  std::optional<PayloadSpool> payloads_;  ///< simplify to pack
  std::optional<NodeSpool> nodes_;        ///< simplify to pack
};

}  // namespace lode::ingest
