#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/pipeline/recorded_build.h"

namespace lode::ingest {

/// A stage of a build. Its constructor names the stages whose results it takes; it holds its own result for
/// later stages. BuildSession runs it, or loads its result if a resumed build had finished it.
class Stage {
 public:
  struct Traits {
    const char* name;                       ///< in reports and progress
    BuildEntry entry;                       ///< journal entry that the finished stage writes
    BuildEntry used_up_by;                  ///< last stage that needs this stage's result
    std::vector<std::string_view> files{};  ///< files that hold the result until then
  };
  /// Work done, for the report.
  struct Work {
    uint64_t items = 0, temporary_bytes = 0;
  };

  explicit Stage(Traits traits) : traits_(std::move(traits)) {}
  virtual ~Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  const Traits& traits() const noexcept { return traits_; }

  /// Returns false if the input has no work for this stage.
  virtual bool isNeeded() const { return true; }
  /// @throws Error.
  virtual Work run() = 0;
  /// Returns whether save() can record the result; false if it is only in memory.
  virtual bool isOnDisk() const { return true; }
  /// Records everything that load() needs besides the files and BuildFacts.
  virtual void save(RecordWriter& record) const = 0;
  /// Restores the result that save() recorded. @param is_used_up  the stages that need the result are
  /// finished and its files are removed. @throws Error kIo, kFormat.
  virtual void load(RecordReader& record, bool is_used_up) = 0;

 private:
  const Traits traits_;
};

}  // namespace lode::ingest
