#include "server/ingest/pipeline/build_session.h"

#include <utility>

#include "common/error.h"
#include "server/ingest/pipeline/stage_clock.h"
#include "server/store/reader.h"

namespace lode::ingest {
BuildSession::BuildSession(const BuildOptions& options, const BuildProgress& progress)
    : options_(options),
      progress_(progress),
      plan_(planMemory(options.memory_bytes, options.threads, options.triangles_per_node)),
      identity_(BuildIdentity::of(options)),
      folder_(options.output, options.temporary_folder) {
  std::error_code ignored;
  if (std::filesystem::exists(folder_.journal(), ignored)) resume();
  if (!journal_) begin();
  folder_.keep(false);
  if (!options.resume) folder_.removeWhenInterrupted();
}

/// Opens the existing journal if this build resumes from it. Otherwise deletes the files of the earlier
/// build. @throws Error kInput if --resume is given but the build has changed.
void BuildSession::resume() {
  bool is_damaged = false;
  try {
    journal_.emplace(Journal::open(
        folder_.journal(),
        [this](uint32_t kind, std::span<const std::byte> bytes) { recorded_.add(kind, bytes); }));
  } catch (const Error&) {
    if (options_.resume && !options_.restart_if_changed) throw;
    is_damaged = true;
  }
  if (recorded_.tasks > 0 && options_.part == BuildPart::kWhole && !options_.resume)
    throw Error(ErrorCode::kInput, options_.output.string() +
                                       ": is being built in parts; finish it, or delete " +
                                       folder_.journal().parent_path().string());
  if (options_.resume && recorded_.identity && !is_damaged) {
    const std::string difference = recorded_.identity->difference(identity_);
    if (!difference.empty() && !options_.restart_if_changed) {
      throw Error(ErrorCode::kInput,
                  "cannot resume the build of " + options_.output.string() + ": " + difference);
    }
    if (difference.empty() && (!recorded_.isPast(BuildEntry::kPacked) || isPackedAlready())) {
      files_.emplace(folder_.openFiles());
      return;
    }
  }
  journal_.reset();
  if (recorded_.identity) folder_.clear(recorded_.identity->temporary_folder);
  recorded_ = {};
  facts_ = {};
  report_ = {};
}

void BuildSession::begin() {
  folder_.keep(false);
  folder_.clear(options_.temporary_folder);
  files_.emplace(folder_.openFiles());
  journal_.emplace(Journal::create(folder_.journal()));
  RecordWriter record;
  identity_.save(record);
  journal_->append(static_cast<uint32_t>(BuildEntry::kBegun), record.bytes());
  folder_.syncFolders();
}

bool BuildSession::isPackedAlready() {
  try {
    RecordReader record(recorded_.stages.at(BuildEntry::kPacked));
    readFacts(record);
    const auto build_id = record.get<Digest>();
    const store::Reader reader(options_.output);
    report_.summary = reader.summary();
    return reader.summary().build_id == build_id;
  } catch (const Error&) {
    return false;
  }
}

bool BuildSession::keep() noexcept {
  const bool is_begun_only = journal_->entries() <= 1;
  folder_.keep(!is_begun_only);
  return !is_begun_only;
}

void BuildSession::run(Stage& stage) {
  if (!loadRecorded(stage) && stage.isNeeded()) {
    const char* name = stage.traits().name;
    if (!recorded_.stages.empty() && report_.resumed_from.empty()) report_.resumed_from = name;
    StageClock clock(report_, name);
    const Stage::Work work = stage.run();
    trimHeap();
    if (stage.isOnDisk()) noteFinished(stage);
    clock.finish(work.items, work.temporary_bytes);
  }
  done_.push_back(&stage);
}

/// Loads the result of a finished stage. @return false if the stage must run.
bool BuildSession::loadRecorded(Stage& stage) {
  const bool is_used_up = recorded_.isPast(stage.traits().used_up_by);
  const auto recorded = recorded_.stages.find(stage.traits().entry);
  if (recorded == recorded_.stages.end()) return is_used_up;
  RecordReader record(recorded->second);
  readFacts(record);
  stage.load(record, is_used_up);
  return true;
}

void BuildSession::readFacts(RecordReader& record) {
  facts_ = record.get<BuildFacts>();
  report_.warnings = record.getTexts();
}

void BuildSession::noteFinished(const Stage& stage) {
  RecordWriter record;
  record.put(facts_);
  record.putTexts(report_.warnings);
  stage.save(record);
  note(stage.traits().entry, record.bytes());
  std::vector<std::string_view> needed = stage.traits().files;
  for (const Stage* before : done_) {
    const Stage::Traits& traits = before->traits();
    if (traits.used_up_by > stage.traits().entry)
      needed.insert(needed.end(), traits.files.begin(), traits.files.end());
  }
  folder_.removeFilesBut(needed);
}

void BuildSession::note(BuildEntry entry, std::span<const std::byte> bytes) {
  folder_.syncFiles();
  journal_->append(static_cast<uint32_t>(entry), bytes);
}

void BuildSession::noteTasks() {
  RecordWriter record;
  record.put(options_.tasks);
  note(BuildEntry::kTasks, record.bytes());
  keep();
}

void BuildSession::warn(std::string warning) {
  if (options_.strict) throw Error(ErrorCode::kInput, warning + " (--strict treats warnings as errors)");
  report_.warnings.push_back(std::move(warning));
}

void BuildSession::warn(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) warn(warning);
}

void BuildSession::refuseForMemory(const std::string& problem) {
  lacks_memory_ = true;
  throw Error(ErrorCode::kLimit, problem);
}

}  // namespace lode::ingest
