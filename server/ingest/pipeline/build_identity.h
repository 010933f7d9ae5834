#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// Identifies a file and its content without reading all of it.
struct FileFingerprint {
  std::string path;  ///< absolute
  uint64_t bytes = 0;
  int64_t modified_ns = 0;  ///< since 1970
  uint64_t content = 0;     ///< hash of head, tail and evenly spread samples

  bool operator==(const FileFingerprint&) const = default;
};

/// Returns zeros, except for the path, if the path is not a readable regular file: its reader reports that.
FileFingerprint fingerprint(const std::filesystem::path& path);

/// Everything that a store's bytes depend on. A build resumes only if it is unchanged. Threads and memory are
/// not part of it (I6 in docs/architecture.md).
struct BuildIdentity {
  struct Texture {
    std::string name;       ///< as written in the input
    FileFingerprint image;  ///< path is empty if no file was found
  };
  FileFingerprint input;
  std::vector<Texture> textures;  ///< named by the input
  uint64_t program = 0;           ///< content of the executable
  std::string temporary_folder;
  ResultOptions options;

  /// @param options  with all defaults filled in.
  static BuildIdentity of(const BuildOptions& options);

  void save(RecordWriter& record) const;
  static BuildIdentity load(RecordReader& record);

  /// Describes the first difference to `now` and its remedy; empty if there is none.
  std::string difference(const BuildIdentity& now) const;

 private:
  std::string textureDifference(const BuildIdentity& now) const;
};

}  // namespace lode::ingest
