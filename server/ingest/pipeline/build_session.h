#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/ingest/disk/build_folder.h"
#include "server/ingest/disk/journal.h"
#include "server/ingest/pipeline/build_facts.h"
#include "server/ingest/pipeline/build_identity.h"
#include "server/ingest/pipeline/recorded_build.h"
#include "server/ingest/pipeline/stage.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/plan/memory_plan.h"

namespace lode::ingest {

/// One build: what was asked for, its folder and journal, what is known of the model and the report. A stage
/// that a resumed build had finished is taken over; one that is finished now is noted in the journal, and
/// then the files that nothing needs any more are removed. Not thread safe.
class BuildSession {
 public:
  /// @param options  complete. @throws Error kInput if the build that is to be resumed was another.
  BuildSession(const BuildOptions& options, const BuildProgress& progress);

  /// Runs a stage or takes it over. @param stage  lives until the last stage has run.
  void run(Stage& stage);
  BuildReport takeReport() { return std::move(report_); }
  /// Leaves what is there for a build that is to go on. @return whether there is anything.
  bool keep() noexcept;
  /// Whether what has failed would not have with more memory.
  bool lacksMemory() const noexcept { return lacks_memory_; }

  // For the stages.
  const BuildOptions& options() const noexcept { return options_; }
  const BuildProgress& progress() const noexcept { return progress_; }
  const MemoryPlan& plan() const noexcept { return plan_; }
  const TemporaryFolder& files() const noexcept { return *files_; }
  /// Where the store is until it is complete.
  std::filesystem::path store() const { return folder_.store(); }
  BuildFacts& facts() noexcept { return facts_; }
  /// What a killed build had finished; to be used up.
  RecordedBuild& recorded() noexcept { return recorded_; }
  /// Of the store, once it is complete.
  void setSummary(ModelSummary summary) { report_.summary = std::move(summary); }
  /// @throws Error kInput if warnings are errors.
  void warn(std::string warning);
  void warn(const std::vector<std::string>& warnings);
  void noteTextureFiles(std::vector<std::string> names) { report_.texture_files = std::move(names); }
  /// @throws Error kLimit always; the same build may do with more memory.
  [[noreturn]] void refuseForMemory(const std::string& problem);
  /// Notes in the journal how far a stage has come, when the names of its files are on the disk.
  void note(BuildEntry entry, std::span<const std::byte> bytes);

 private:
  void begin();
  void resume();
  bool isPackedAlready();
  bool takeOver(Stage& stage);
  void noteFinished(const Stage& stage);
  void readKnown(RecordReader& record);

  const BuildOptions options_;
  const BuildProgress& progress_;
  const MemoryPlan plan_;
  const BuildIdentity identity_;
  BuildFolder folder_;
  BuildReport report_;
  RecordedBuild recorded_;
  std::optional<Journal> journal_;
  std::optional<TemporaryFolder> files_;
  BuildFacts facts_;
  bool lacks_memory_ = false;
  std::vector<const Stage*> done_;  ///< run or taken over
};

}  // namespace lode::ingest
