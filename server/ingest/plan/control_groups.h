#pragma once

#include <cstdint>
#include <filesystem>

namespace lode::ingest {

/// The least memory limit of the control groups that this process is in, their ancestors too: what a
/// container or a service is killed beyond. Of version 1 memory.limit_in_bytes counts, of version 2
/// memory.max and memory.high; what is missing or cannot be read limits nothing. Where a container sees only
/// its own part of the tree, that part's top counts as its group.
/// @param root  folder that holds proc/self/cgroup and sys/fs/cgroup. @return ~0 without a limit. Thread
/// safe. Source: Linux, Documentation/admin-guide/cgroup-v2.rst and cgroup-v1/memory.rst.
uint64_t controlGroupMemoryBytes(const std::filesystem::path& root = "/");

}  // namespace lode::ingest
