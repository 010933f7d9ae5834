#pragma once

#include <cstdint>
#include <filesystem>

namespace lode {

/// Returns the number of bytes of memory that this process may use: the smallest of physical RAM, the soft
/// limits RLIMIT_AS and RLIMIT_DATA, and the limits of the process's control groups. Thread safe.
/// @param root  folder that contains proc/self/cgroup and sys/fs/cgroup; tests pass a folder of their own.
uint64_t memoryLimitBytes(const std::filesystem::path& root = "/");

/// Returns the smallest memory limit of this process's control groups and their ancestors, or ~0 if there is
/// no limit. Version 1 of control groups has memory.limit_in_bytes. Version 2 has memory.max, beyond which
/// the kernel kills the process, and memory.high, beyond which the kernel slows the process down. A missing
/// file, or a file without a number, sets no limit. If a container sees only part of the tree of groups, the
/// topmost visible folder stands for the group of the container's processes. Thread safe. Source: Linux,
/// Documentation/admin-guide/cgroup-v2.rst and cgroup-v1/memory.rst.
uint64_t controlGroupMemoryBytes(const std::filesystem::path& root = "/");

}  // namespace lode
