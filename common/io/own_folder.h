#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "common/error.h"

namespace lode {

/// Purpose of a folder for error messages, and the remedy if the folder cannot be used. The remedy is either
/// text of the message, or a pair of codes that the program puts in words.
struct FolderUse {
  const char* what;
  const char* remedy = nullptr;        ///< advice in the error's text; if null, the error has a code below
  Remedy if_not_made = Remedy::kNone;  ///< remedy if the system refuses to make the folder
  Remedy if_foreign = Remedy::kNone;   ///< remedy if isOwnFolder() is false for an existing path
};

/// Returns true if the path is a folder that this user owns and no other user can write to. Returns false for
/// a link, because another user may have placed the link to redirect this program's files.
bool isOwnFolder(const std::filesystem::path& path) noexcept;

/// Creates a folder that only this user can use (mode 0700). If isOwnFolder() is true for an existing folder,
/// changes its mode to 0700.
/// @throws Error kIo, also if isOwnFolder() is false for an existing path.
void makeOwnFolder(const std::filesystem::path& path, const FolderUse& use);

/// Creates the missing folders above the path with mode 0700, then calls makeOwnFolder(). @throws Error kIo.
void makeOwnFolders(const std::filesystem::path& path, const FolderUse& use);

/// Refuses an existing path for which isOwnFolder() is false; accepts a missing path. @throws Error kIo.
void refuseForeignFolder(const std::filesystem::path& path, const FolderUse& use);

/// Replaces a file in a folder of makeOwnFolder() with a file that only this user can read (mode 0600). The
/// file appears complete under its name, but is not synced to disk. Creates a temporary file in the same
/// folder, with O_EXCL and a name that begins with kNewFile. @return false, with errno set, on failure.
/// Thread safe.
bool writeOwnFile(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// Returns true if a user other than this user and root can read or change a file, so that the file is unsafe
/// for secrets. If root owns the file, ignores read permission for its group, because services can receive
/// secrets through a group. Returns false if the file is missing, deleted or not a regular file.
bool isOpenToOthers(const std::filesystem::path& file) noexcept;

/// Start of the names of temporary files that writeOwnFile() creates. A killed process may leave such a file.
constexpr const char* kNewFile = ".new-";

}  // namespace lode
