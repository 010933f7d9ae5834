#include "client/app/window/recent_targets.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <span>
#include <system_error>

#include <nlohmann/json.hpp>

#include "client/app/cli/store_cache.h"
#include "client/app/cli/target.h"
#include "common/error.h"
#include "common/io/own_folder.h"

namespace lode::app {
namespace {

constexpr size_t kMostTargetBytes = 4096;  ///< longest target that is kept
/// Longest file that read() accepts. JSON may escape each byte of a target with six characters.
constexpr size_t kMostListBytes = kMostRecentTargets * (6 * kMostTargetBytes + 16);

}  // namespace

std::vector<std::string> RecentTargets::read() const {
  std::error_code failed;
  const auto size =
      std::filesystem::is_regular_file(file_, failed) ? std::filesystem::file_size(file_, failed) : 0;
  if (failed || size == 0 || size > kMostListBytes) return {};
  std::string text(size, '\0');
  std::ifstream file(file_, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_array()) return {};
  std::vector<std::string> targets;
  for (const auto& target : json)
    if (target.is_string() && targets.size() < kMostRecentTargets)
      targets.push_back(target.get<std::string>());
  return targets;
}

void RecentTargets::add(std::string_view target) const {
  const std::string name = fullName(target);
  if (name.empty() || name.size() > kMostTargetBytes) return;
  std::vector<std::string> targets = read();
  std::erase(targets, name);
  targets.insert(targets.begin(), name);
  if (targets.size() > kMostRecentTargets) targets.resize(kMostRecentTargets);
  const std::string text =
      nlohmann::json(targets).dump(0, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  try {
    makeOwnFolders(file_.parent_path(), kCacheFolderUse);
    writeOwnFile(file_, std::as_bytes(std::span(text)));
  } catch (const Error&) {  // the list stays as it is
  }
}

bool isMissing(std::string_view target) {
  std::error_code failed;
  return target.find("://") == std::string_view::npos && !std::filesystem::exists(target, failed);
}

}  // namespace lode::app
