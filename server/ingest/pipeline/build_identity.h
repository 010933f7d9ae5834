#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/ingest/disk/record_bytes.h"
#include "server/ingest/plan/build_options.h"

namespace lode::ingest {

/// Identifies a file by its path, size, modification time and samples of its content. Large files are not
/// read completely.
struct FileFingerprint {
  std::string path;  ///< absolute path
  uint64_t bytes = 0;
  int64_t modified_ns = 0;  ///< time of the last change, in ns since 1970
  uint64_t content = 0;     ///< hash of the file's start, its end and evenly spaced samples

  bool operator==(const FileFingerprint&) const = default;
};

/// Computes the fingerprint of a file. Sets only the path if it is not a readable regular file; the stage
/// that reads the file reports the error.
FileFingerprint fingerprint(const std::filesystem::path& path);

/// Returns a hash of the running program and of the libraries that determine a store's bytes: Draco and libm.
uint64_t programContent();

/// All inputs and options that determine a store's bytes. A build resumes only if its identity is unchanged.
/// The number of threads and the memory budget are not part of the identity (I6 in docs/architecture.md).
struct BuildIdentity {
  struct Texture {
    std::string name;       ///< name as written in the input
    FileFingerprint image;  ///< fingerprint of the image, with an empty path if no file was found
  };
  std::vector<FileFingerprint> inputs;
  std::vector<Texture> textures;  ///< images that the input names
  FileFingerprint lattice_of;     ///< BuildOptions::lattice_of; an empty path if that is empty
  uint64_t program = 0;           ///< FileFingerprint::content of the executable
  std::string temporary_folder;
  ResultOptions options;

  /// Returns the identity of a build. @param options  options with all defaults filled in.
  static BuildIdentity of(const BuildOptions& options);

  void save(RecordWriter& record) const;
  static BuildIdentity load(RecordReader& record);

  /// Describes the first difference from `now`, and its remedy. Returns an empty string if nothing differs.
  /// @param anew  advice to start again, such as "build without --resume".
  std::string difference(const BuildIdentity& now, const std::string& anew = "build without --resume") const;

 private:
  std::string textureDifference(const BuildIdentity& now, const std::string& anew) const;
};

}  // namespace lode::ingest
