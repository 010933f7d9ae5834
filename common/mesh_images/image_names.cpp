#include "common/mesh_images/image_names.h"

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace lode {
namespace {

/// Returns the last component of a path without its extension, cut to 100 bytes. Replaces characters that
/// some file systems reject.
std::string baseName(const std::string& name) {
  std::string base = name.substr(name.find_last_of("/\\") + 1);
  if (const size_t dot = base.rfind('.'); dot != std::string::npos && dot > 0) base.resize(dot);
  for (char& c : base)
    if (std::string_view("<>:\"|?*").find(c) != std::string_view::npos) c = '_';
  constexpr size_t kLongest = 100;
  if (base.size() > kLongest) {
    base.resize(kLongest);
    while (!base.empty() && (static_cast<uint8_t>(base.back()) & 0xc0) == 0x80) base.pop_back();
    if (!base.empty() && static_cast<uint8_t>(base.back()) >= 0xc0) base.pop_back();
  }
  return base.empty() ? "texture" : base;
}

}  // namespace

std::string ImageNames::next(const std::string& texture_name) {
  const std::string stem = stem_ + "_" + baseName(texture_name);
  std::string name = stem + ".png";
  for (int copy = 2; !taken_.insert(name).second; ++copy) name = stem + "-" + std::to_string(copy) + ".png";
  return name;
}

}  // namespace lode
