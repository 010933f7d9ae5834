#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace lode {

/// Reads from an offset until `bytes` is full or the file ends, whatever interrupts it or comes in parts.
/// @return bytes read; fewer than asked for only at the end of the file; nothing, with errno set, if it
/// fails.
std::optional<size_t> readAt(int file, uint64_t offset, std::span<std::byte> bytes) noexcept;

/// Writes all bytes at an offset, whatever interrupts it or goes in parts.
/// @return false, with errno set, if it fails.
bool writeAt(int file, uint64_t offset, std::span<const std::byte> bytes) noexcept;

/// Writes all bytes where the file stands, whatever interrupts it or goes in parts.
/// @return false, with errno set, if it fails.
bool append(int file, std::span<const std::byte> bytes) noexcept;

/// What an error of a file means: the system's words, but for a disk or a quota that is full
/// "the disk is full; " and what to do.
std::string fileErrorInWords(int error, const char* when_full = "free some space");

}  // namespace lode
