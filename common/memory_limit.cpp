#include "common/memory_limit.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include <sys/resource.h>
#include <unistd.h>

namespace lode {
namespace {

constexpr uint64_t kNoLimit = ~uint64_t{0};
constexpr std::string_view kLimitsOfVersion1[] = {"memory.limit_in_bytes"};
constexpr std::string_view kLimitsOfVersion2[] = {"memory.max", "memory.high"};

/// Returns kNoLimit for "max" and for text that is not a number.
uint64_t readLimit(const std::filesystem::path& file) {
  std::string text;
  std::ifstream(file) >> text;
  uint64_t limit = kNoLimit;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), limit);
  return problem == std::errc{} && end == text.data() + text.size() ? limit : kNoLimit;
}

/// Returns the smallest limit of a group and its ancestors, up to the top of the tree.
uint64_t leastLimit(const std::filesystem::path& top, std::string_view group,
                    std::span<const std::string_view> names) {
  uint64_t least = kNoLimit;
  const auto readFolder = [&](const std::filesystem::path& folder) {
    for (const std::string_view name : names) least = std::min(least, readLimit(folder / name));
  };
  std::filesystem::path folder = top;
  readFolder(folder);
  for (const std::filesystem::path& part : std::filesystem::path(group).relative_path()) {
    if (part == "..") return least;  // the group lies outside the part of the tree that this process sees
    readFolder(folder /= part);
  }
  return least;
}

bool hasMemory(std::string_view controllers) {
  while (!controllers.empty()) {
    const size_t comma = controllers.find(',');
    if (controllers.substr(0, comma) == "memory") return true;
    controllers.remove_prefix(comma == std::string_view::npos ? controllers.size() : comma + 1);
  }
  return false;
}

uint64_t physicalMemoryBytes() noexcept {
  return static_cast<uint64_t>(std::max(1L, sysconf(_SC_PHYS_PAGES))) *
         static_cast<uint64_t>(std::max(1L, sysconf(_SC_PAGESIZE)));
}

uint64_t softLimit(int resource) noexcept {
  rlimit limit{};
  return getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY ? limit.rlim_cur : kNoLimit;
}

}  // namespace

uint64_t memoryLimitBytes(const std::filesystem::path& root) {
  return std::min(
      {physicalMemoryBytes(), softLimit(RLIMIT_AS), softLimit(RLIMIT_DATA), controlGroupMemoryBytes(root)});
}

uint64_t controlGroupMemoryBytes(const std::filesystem::path& root) {
  const std::filesystem::path tops = root / "sys/fs/cgroup";
  std::ifstream groups(root / "proc/self/cgroup");
  uint64_t least = kNoLimit;
  for (std::string line; std::getline(groups, line);) {  // number:controllers:path
    const size_t first = line.find(':');
    const size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string_view controllers = std::string_view(line).substr(first + 1, second - first - 1);
    const std::string_view group = std::string_view(line).substr(second + 1);
    if (controllers.empty()) {
      least = std::min({least, leastLimit(tops, group, kLimitsOfVersion2),
                        leastLimit(tops / "unified", group, kLimitsOfVersion2)});
    } else if (hasMemory(controllers)) {
      least = std::min(least, leastLimit(tops / "memory", group, kLimitsOfVersion1));
    }
  }
  return least;
}

}  // namespace lode
