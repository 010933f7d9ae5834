#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// Identifies a file by its path, size, time of change and samples of its content. Only the samples are read.
struct FileFingerprint {
  std::string path;  ///< absolute path
  uint64_t bytes = 0;
  int64_t modified_ns = 0;  ///< time of the last change, in ns since 1970
  uint64_t content = 0;     ///< hash of the file's head, its tail and evenly spread samples

  bool operator==(const FileFingerprint&) const = default;
};

/// Computes the fingerprint of a file. Returns the path and zeros if the path is not a readable regular file;
/// the stage that reads the file reports the error.
FileFingerprint fingerprint(const std::filesystem::path& path);

/// All inputs and options that determine a store's bytes. A build resumes only if its identity is unchanged.
/// The number of threads and the memory budget are not part of the identity (I6 in docs/architecture.md).
struct BuildIdentity {
  struct Texture {
    std::string name;       ///< name as written in the input
    FileFingerprint image;  ///< fingerprint of the image, with an empty path if no file was found
  };
  FileFingerprint input;
  std::vector<Texture> textures;  ///< images that the input names
  uint64_t program = 0;           ///< hash of the executable
  std::string temporary_folder;
  ResultOptions options;

  /// Returns the identity of a build. @param options  options with all defaults filled in.
  static BuildIdentity of(const BuildOptions& options);

  void save(RecordWriter& record) const;
  static BuildIdentity load(RecordReader& record);

  /// Describes the first difference to `now` and its remedy. Returns an empty text if nothing differs.
  std::string difference(const BuildIdentity& now) const;

 private:
  std::string textureDifference(const BuildIdentity& now) const;
};

}  // namespace lode::ingest
