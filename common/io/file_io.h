#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace lode {

/// Reads from an offset until `bytes` is full or the file ends. Retries partial and interrupted reads.
/// @return bytes read, fewer than bytes.size() only at the end of the file; nothing, with errno set, on
/// failure.
std::optional<size_t> readAt(int file, uint64_t offset, std::span<std::byte> bytes) noexcept;

/// Writes all bytes at an offset. Retries partial and interrupted writes.
/// @return false, with errno set, on failure.
bool writeAt(int file, uint64_t offset, std::span<const std::byte> bytes) noexcept;

/// Writes all bytes at the file's position. Retries partial and interrupted writes.
/// @return false, with errno set, on failure.
bool append(int file, std::span<const std::byte> bytes) noexcept;

/// Refuses the path of a folder, a pipe or a device, because opening or reading it may fail or block. Accepts
/// a missing path. @param wanted  words for the error message, such as "a camera path".
/// @throws Error kIo.
void refuseUnlessFile(const std::filesystem::path& path, const char* wanted);

/// Returns the system's message for an errno. For a full disk or quota, returns "the disk is full; " followed
/// by `when_full`.
std::string fileErrorInWords(int error, const char* when_full = "free some space");

}  // namespace lode
