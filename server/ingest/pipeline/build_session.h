#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/ingest/disk/build_folder.h"
#include "server/ingest/disk/journal.h"
#include "server/ingest/pipeline/build_identity.h"
#include "server/ingest/pipeline/recorded_build.h"
#include "server/ingest/pipeline/stage.h"
#include "server/ingest/plan/build_options.h"
#include "server/ingest/plan/memory_plan.h"

namespace lode::ingest {

/// State of one build: options, folder, journal, facts about the model and report. Loads the stages that an
/// earlier, interrupted build had finished. Runs the other stages, records each in the journal and removes
/// files that no later stage needs. Not thread safe.
class BuildSession {
 public:
  /// @param options  options with all defaults filled in. @throws Error kInput if the build to resume had
  /// another input or other options.
  BuildSession(const BuildOptions& options, const BuildProgress& progress);

  /// Runs or loads a stage. @param stage  must outlive the last call of run(), which reads the traits of all
  /// earlier stages.
  void run(Stage& stage);
  BuildReport takeReport() { return std::move(report_); }
  /// Notes the number of tasks, and keeps the finished work for them.
  void noteTasks();
  /// Keeps the finished work so that a later build can resume. @return false if no work is finished.
  bool keep() noexcept;
  /// Returns true if the build failed for lack of memory.
  bool lacksMemory() const noexcept { return lacks_memory_; }

  // Functions that stages call.
  const BuildOptions& options() const noexcept { return options_; }
  const BuildProgress& progress() const noexcept { return progress_; }
  const MemoryPlan& plan() const noexcept { return plan_; }
  const TemporaryFolder& files() const noexcept { return *files_; }
  /// Returns the temporary path under which the store is written.
  std::filesystem::path store() const { return folder_.store(); }
  BuildFacts& facts() noexcept { return facts_; }
  /// Returns the recorded work of the build to resume. Each stage moves its own part out.
  RecordedBuild& recorded() noexcept { return recorded_; }
  /// Sets the report's summary. The last stage calls this when the store is complete.
  void setSummary(ModelSummary summary) { report_.summary = std::move(summary); }
  /// Adds a warning to the report. @throws Error kInput with --strict.
  void warn(std::string warning);
  void warn(const std::vector<std::string>& warnings);
  void noteTextureFile(std::string name) { report_.texture_files.push_back(std::move(name)); }
  /// Ends a build that would succeed with more memory. @throws Error kLimit always.
  [[noreturn]] void refuseForMemory(const std::string& problem);
  /// Syncs the folder of temporary files to disk, then appends an entry to the journal.
  void note(BuildEntry entry, std::span<const std::byte> bytes);

 private:
  void begin();
  void resume();
  bool isPackedAlready();
  bool loadRecorded(Stage& stage);
  void noteFinished(const Stage& stage);
  void readFacts(RecordReader& record);

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
  std::vector<const Stage*> done_;  ///< stages that have been run or loaded
};

}  // namespace lode::ingest
