#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "common/codec/blob.h"
#include "server/ingest/nodes/treelet_file.h"

namespace lode::ingest {

constexpr std::string_view kTreeletEnding = ".treelet";  ///< end of the names of treelets' files

/// The treelets of a build, and optionally a shared folder of treelets that several builds reuse. The build's
/// own folder holds a link to, or a copy of, each treelet that the build uses, so that trimming the shared
/// folder does not affect the build. Thread safe.
class TreeletFolder {
 public:
  /// @param own     folder of the build; created if it is missing. @param shared  folder whose subfolder
  /// `treelets` is shared, or an empty path; created if it is missing. @throws Error kIo.
  TreeletFolder(std::filesystem::path own, const std::filesystem::path& shared);

  /// Returns a finished treelet from the build's own folder or else from the shared folder. Removes a damaged
  /// file. @return nothing if neither folder has an intact file of this name.
  std::optional<TreeletFile> find(const Digest& name) const;
  /// Returns true if find() can look for a treelet's file in the build's own folder.
  bool has(const Digest& name) const;
  TreeletWriter create(const Digest& name) const { return TreeletWriter(ownPath(name)); }
  /// Returns when all finished treelets are on the disk. @throws Error kIo.
  void sync() const;
  /// Adds a finished treelet to the shared folder. Does nothing if that fails, because only later builds
  /// need the file there.
  void share(const Digest& name) const noexcept;

 private:
  static std::string fileName(const Digest& name) { return toHex(name).append(kTreeletEnding); }
  std::filesystem::path ownPath(const Digest& name) const { return own_ / fileName(name); }
  std::filesystem::path sharedPath(const Digest& name) const { return shared_ / fileName(name); }

  const std::filesystem::path own_, shared_;
};

/// Removes the treelets that builds have not used for longest, until the others have at most `limit_bytes`.
/// Does not touch other files.
void trimSharedTreelets(const std::filesystem::path& shared, uint64_t limit_bytes);

}  // namespace lode::ingest
