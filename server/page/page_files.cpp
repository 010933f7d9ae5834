#include "server/page/page_files.h"

#include <algorithm>

namespace lode::page {

const PageFile* findFile(std::span<const PageFile> files, std::string_view name) noexcept {
  const auto found = std::ranges::find(files, name, &PageFile::name);
  return found == files.end() ? nullptr : &*found;
}

}  // namespace lode::page
