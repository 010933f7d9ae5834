#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// What tells a file from another or from itself after a change, without reading all of it.
struct FileFingerprint {
  std::string path;  ///< absolute
  uint64_t bytes = 0;
  int64_t modified_ns = 0;  ///< since 1970
  uint64_t content = 0;     ///< hash of its head, its tail and samples evenly spread between

  bool operator==(const FileFingerprint&) const = default;
};

/// All zero but the path if it is no regular file that can be read: whoever reads it says so better.
FileFingerprint fingerprint(const std::filesystem::path& path);

/// What must be the same for a build to be gone on with: all that the store's bytes follow from. Threads and
/// memory are not among it (I6).
struct BuildIdentity {
  struct Texture {
    std::string name;       ///< as the input has it
    FileFingerprint image;  ///< without a path: there is none
  };
  FileFingerprint input;
  std::vector<Texture> textures;  ///< that the input names
  uint64_t program = 0;           ///< content of the executable
  std::string temporary_folder;
  uint32_t triangles_per_node = 0;
  uint8_t simplifier = 0;
  float crease_angle_deg = 0;
  bool skip_bad = false, strict = false;

  /// @param options  complete.
  static BuildIdentity of(const BuildOptions& options);

  void save(RecordWriter& record) const;
  static BuildIdentity load(RecordReader& record);

  /// In words, what is different in `now`, and what to do; empty if nothing is.
  std::string difference(const BuildIdentity& now) const;

 private:
  std::string textureDifference(const BuildIdentity& now) const;
};

}  // namespace lode::ingest
