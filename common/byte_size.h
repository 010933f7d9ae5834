#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lode {

/// Reads a count of bytes as people write it: "500000000", "512MB", "1.5 GB", "512MiB". KB, MB, GB and TB are
/// powers of 1000; KiB, MiB, GiB and TiB of 1024, and so are K, M, G and T, as GNU's tools have it; in either
/// case.
/// @throws Error kUsage that says how to write one.
uint64_t parseByteSize(std::string_view text);

/// A number of bytes for people: "1.5 MB".
std::string describeBytes(uint64_t bytes);

/// As an option takes it, of three digits and no less than `bytes`: "181MB".
std::string byteSizeAtLeast(uint64_t bytes);

}  // namespace lode
