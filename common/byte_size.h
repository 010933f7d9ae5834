#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lode {

/// Parses a number of bytes: "500000000", "512MB", "1.5 GB", "512MiB". KB, MB, GB and TB are powers of 1000;
/// KiB, MiB, GiB and TiB, and K, M, G and T as in GNU's tools, are powers of 1024. Case does not matter.
/// @throws Error kUsage that shows the syntax.
uint64_t parseByteSize(std::string_view text);

/// Formats a number of bytes for people: "1.5 MB".
std::string describeBytes(uint64_t bytes);

/// Formats a number of bytes in the syntax of options, rounded up to three significant digits: "181MB".
std::string byteSizeAtLeast(uint64_t bytes);

}  // namespace lode
