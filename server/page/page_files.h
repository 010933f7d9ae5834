#pragma once

#include <cstddef>
#include <span>
#include <string_view>

/// The page that shows models in a browser (client/web). Its files are part of the program.
namespace lode::page {

/// A file of the page. The members stay valid until the program ends.
struct PageFile {
  std::string_view name;  ///< "index.html", "core.wasm"
  std::span<const std::byte> bytes;
  std::string_view hash;  ///< hash of the bytes, 32 hexadecimal digits
};

/// Returns the files of client/web/dist, or no file if the program was built without this folder. Thread
/// safe.
std::span<const PageFile> builtInPage() noexcept;

/// Returns the file with a name, or null. Thread safe.
const PageFile* findFile(std::span<const PageFile> files, std::string_view name) noexcept;

}  // namespace lode::page
