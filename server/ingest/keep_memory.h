#pragma once

namespace lode::ingest {

/// Lets the allocator keep what is freed for the next node (32 MiB a thread), and take blocks of up to 8 MiB
/// from it: a node's vectors would otherwise come from the system anew each time, page by page, which costs
/// a fifth of the simplifier's time. For the whole process; call it before the threads start.
void keepFreedMemory() noexcept;

}  // namespace lode::ingest
