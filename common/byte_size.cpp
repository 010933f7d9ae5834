#include "common/byte_size.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>

#include "common/error.h"

namespace lode {
namespace {

/// @param name  unit in lower case; "" means bytes.
std::optional<uint64_t> unitOf(std::string_view name) {
  if (name.empty() || name == "b") return 1;
  const size_t power = std::string_view("kmgt").find(name[0]);
  const std::string_view rest = name.substr(1);
  if (power == std::string_view::npos || (!rest.empty() && rest != "b" && rest != "ib")) return std::nullopt;
  const uint64_t base = rest == "b" ? 1000 : 1024;
  uint64_t unit = base;
  for (size_t i = 0; i < power; ++i) unit *= base;
  return unit;
}

[[noreturn]] void refuseSize(std::string_view text) {
  throw Error(ErrorCode::kUsage,
              "'" + std::string(text) + "' is not a count of bytes; write 500000000, 512MB, 1.5GB or 512MiB");
}

}  // namespace

uint64_t parseByteSize(std::string_view text) {
  const char* const end = text.data() + text.size();
  const size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  std::string name(text.substr(digits));
  if (name.starts_with(' ')) name.erase(0, 1);
  std::ranges::transform(name, name.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::optional<uint64_t> unit = unitOf(name);
  if (!unit) refuseSize(text);
  constexpr uint64_t kMost = std::numeric_limits<uint64_t>::max();
  uint64_t whole = 0;
  const auto [after_whole, bad_whole] = std::from_chars(text.data(), end, whole);
  if (bad_whole == std::errc() && after_whole == text.data() + digits) {
    if (whole > kMost / *unit) refuseSize(text);
    return whole * *unit;
  }
  double value = 0;
  const auto [after, bad] =
      std::from_chars(text.data(), text.data() + digits, value, std::chars_format::fixed);
  const double bytes = std::round(value * static_cast<double>(*unit));
  if (bad != std::errc() || after != text.data() + digits || *unit == 1 || bytes >= 0x1p64) refuseSize(text);
  return static_cast<uint64_t>(bytes);
}

std::string describeBytes(uint64_t bytes) {
  if (bytes == 1) return "1 byte";
  constexpr std::array kUnits{"bytes", "KB", "MB", "GB", "TB"};
  double value = static_cast<double>(bytes);
  size_t unit = 0;
  // A value of 999.95 would print as 1000.0.
  const auto isTooLong = [&] { return value >= (unit == 0 ? 1000 : 999.95); };
  for (; isTooLong() && unit + 1 < kUnits.size(); ++unit) value /= 1000;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), unit == 0 ? "%.0f %s" : "%.1f %s", value, kUnits[unit]);
  return text.data();
}

std::string byteSizeAtLeast(uint64_t bytes) {
  if (bytes < 1000) return std::to_string(bytes);
  uint64_t step = 10;  // place value of the last of three decimal digits
  for (const char* unit : {"KB", "MB", "GB", "TB"}) {
    for (int decimals = 2; decimals >= 0; --decimals, step *= 10) {
      const uint64_t steps = bytes / step + (bytes % step != 0 ? 1 : 0);
      if (steps >= 1000) continue;
      std::array<char, 32> text{};
      std::snprintf(text.data(), text.size(), "%.*f%s", decimals,
                    static_cast<double>(steps) / std::pow(10, decimals), unit);
      return text.data();
    }
  }
  return std::to_string(bytes);
}

}  // namespace lode
