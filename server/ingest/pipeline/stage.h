#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/pipeline/recorded_build.h"

namespace lode::ingest {

/// A stage of a build, which BuildSession runs, or takes over from the build that is resumed. It is made of
/// those before it, takes from them what they made, and holds what it makes for those after it.
class Stage {
 public:
  struct Nature {
    const char* name;       ///< in reports
    BuildEntry entry;       ///< by which the journal vouches for it
    BuildEntry used_up_by;  ///< the stage after which nothing needs any more what this one made
    std::vector<std::string_view> files{};  ///< that it leaves until then
  };
  /// What was done, for the report.
  struct Work {
    uint64_t items = 0, temporary_bytes = 0;
  };

  explicit Stage(Nature nature) : nature_(std::move(nature)) {}
  virtual ~Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  const Nature& nature() const noexcept { return nature_; }

  /// Whether the input has anything for this stage.
  virtual bool isNeeded() const { return true; }
  /// Does the work. @throws Error.
  virtual Work run() = 0;
  /// Whether what run() made can be saved: false if it is in memory alone.
  virtual bool isOnDisk() const { return true; }
  /// Notes what load() needs beside the files and BuildFacts.
  virtual void save(RecordWriter& record) const = 0;
  /// Takes over what save() noted. @param is_used_up  the stage that needs it is finished, the files are
  /// gone.
  /// @throws Error kIo, kFormat.
  virtual void load(RecordReader& record, bool is_used_up) = 0;

 private:
  const Nature nature_;
};

}  // namespace lode::ingest
