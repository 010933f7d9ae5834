#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/pipeline/recorded_build.h"

namespace lode::ingest {

/// A stage of a build. A derived class takes the stages that it depends on in its constructor, and keeps its
/// own result for later stages. BuildSession runs the stage, or loads the result if an earlier, interrupted
/// build had finished the stage.
class Stage {
 public:
  struct Traits {
    const char* name;                       ///< name in reports and progress
    BuildEntry entry;                       ///< journal entry that the finished stage writes
    BuildEntry used_up_by;                  ///< last stage that needs this stage's result
    std::vector<std::string_view> files{};  ///< files that store the result until `used_up_by` is finished
  };
  /// Amount of work done, for the report.
  struct Work {
    uint64_t items = 0, temporary_bytes = 0;
  };

  explicit Stage(Traits traits) : traits_(std::move(traits)) {}
  virtual ~Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  const Traits& traits() const noexcept { return traits_; }

  /// Returns false if the stage has nothing to do for this input.
  virtual bool isNeeded() const { return true; }
  /// Does the work of the stage. @throws Error.
  virtual Work run() = 0;
  /// Returns true if save() can record the result. Returns false if the result is only in memory.
  virtual bool isOnDisk() const { return true; }
  /// Writes the data that load() needs in addition to the files and BuildFacts.
  virtual void save(RecordWriter& record) const = 0;
  /// Restores the result that save() recorded. @param is_used_up  true if all stages that need the result are
  /// finished; its files are then already deleted. @throws Error kIo, kFormat.
  virtual void load(RecordReader& record, bool is_used_up) = 0;

 private:
  const Traits traits_;
};

}  // namespace lode::ingest
