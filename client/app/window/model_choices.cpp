#include "client/app/window/model_choices.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <span>
#include <system_error>

#include <nlohmann/json.hpp>

#include "client/app/cli/store_cache.h"
#include "client/app/cli/target.h"
#include "client/app/window/settings.h"
#include "common/codec/blob.h"
#include "common/error.h"
#include "common/io/own_folder.h"
#include "common/up_axis.h"

namespace lode::app {
namespace {

constexpr size_t kMostBytes = 256;  ///< longest file that read() accepts

std::string fileNameOf(std::string_view target) {
  const std::string name = fullName(target);
  return toHex(digestOf(std::as_bytes(std::span(name)))) + ".json";
}

std::string textOf(const nlohmann::json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace

KeptChoices::KeptChoices(const std::filesystem::path& folder, std::string_view target)
    : folder_(folder / "choices"), file_(folder_ / fileNameOf(target)) {}

ModelChoices KeptChoices::read() const {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file_, ignored)) return {};
  std::array<char, kMostBytes + 1> bytes{};
  std::ifstream file(file_, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  const auto size = static_cast<size_t>(file.gcount());
  if (size == 0 || size > kMostBytes) return {};
  const auto json = nlohmann::json::parse(bytes.begin(), bytes.begin() + size, nullptr, false);
  if (!json.is_object()) return {};
  ModelChoices choices{textOf(json, "up"), textOf(json, "unit")};
  if (!parseAxis(choices.up)) choices.up.clear();
  if (std::ranges::find(kUnits, choices.unit) == kUnits.end()) choices.unit.clear();
  return choices;
}

void KeptChoices::keep(const ModelChoices& choices) const {
  nlohmann::json json = nlohmann::json::object();
  if (!choices.up.empty()) json["up"] = choices.up;
  if (!choices.unit.empty()) json["unit"] = choices.unit;
  const std::string text = json.dump() + "\n";
  try {
    makeOwnFolders(folder_.parent_path(), kCacheFolderUse);
    makeOwnFolder(folder_, kCacheFolderUse);
    writeOwnFile(file_, std::as_bytes(std::span(text)));
  } catch (const Error&) {  // the choices last until the window is closed
  }
}

}  // namespace lode::app
