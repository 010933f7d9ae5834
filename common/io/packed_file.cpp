#include "common/io/packed_file.h"

#include <algorithm>
#include <array>

namespace lode {
namespace {

using namespace std::string_view_literals;

struct Packing {
  std::string_view magic, name, unpack;
  bool is_archive = false;  ///< true if `unpack FILE` extracts files, false if it prints the content
};

constexpr std::array kPackings{
    Packing{"\x1f\x8b"sv, "compressed with gzip", "gzip -dc"},
    Packing{"BZh"sv, "compressed with bzip2", "bzip2 -dc"},
    Packing{"\xfd\x37zXZ\0"sv, "compressed with xz", "xz -dc"},
    Packing{"\x28\xb5\x2f\xfd"sv, "compressed with zstd", "zstd -dc"},
    Packing{"\x04\x22\x4d\x18"sv, "compressed with lz4", "lz4 -dc"},
    Packing{"\x1f\x9d"sv, "compressed with compress", "gzip -dc"},
    Packing{"LZIP"sv, "compressed with lzip", "lzip -dc"},
    Packing{"PK\x03\x04"sv, "a zip archive", "unzip", true},
    Packing{"7z\xbc\xaf\x27\x1c"sv, "a 7z archive", "7z x", true},
    Packing{"Rar!\x1a\x07"sv, "a rar archive", "unrar x", true},
};
constexpr size_t kTarMagicAt = 257;

/// Returns the path as one word of a shell command, quoted if necessary.
std::string shellWord(const std::string& path) {
  constexpr std::string_view kSafe =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./,:@%=";
  if (path.find_first_not_of(kSafe) == path.npos) return path;
  std::string word = "'";
  for (const char c : path) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

/// Returns true if the name says that the compressed content is a tar archive.
bool namesTar(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  constexpr std::array kShort{".tgz"sv, ".tbz"sv, ".tbz2"sv, ".txz"sv, ".tzst"sv};
  return path.stem().extension() == ".tar" || std::ranges::find(kShort, ending) != kShort.end();
}

/// Returns the name for the unpacked file: the path without the ending of the compression, with .ply or .lode
/// at the end.
std::filesystem::path unpackedName(const std::filesystem::path& path) {
  std::filesystem::path name = path;
  const auto isModel = [](const std::filesystem::path& file) {
    return file.extension() == ".ply" || file.extension() == ".lode";
  };
  if (isModel(path)) return name.replace_extension("unpacked" + path.extension().string());
  name.replace_extension();
  return isModel(name) ? name : name.replace_extension(".ply");
}

}  // namespace

std::optional<std::string> packedFileInWords(const std::filesystem::path& path, std::string_view head) {
  const std::string file = shellWord(path.string());
  if (head.size() > kTarMagicAt && head.substr(kTarMagicAt).starts_with("ustar"))
    return "is a tar archive; unpack it first: tar -xf " + file;
  const auto* const packing = std::find_if(kPackings.begin(), kPackings.end(),
                                           [&](const Packing& each) { return head.starts_with(each.magic); });
  if (packing == kPackings.end()) return std::nullopt;
  std::string command = std::string(packing->unpack) + " " + file;
  if (!packing->is_archive && namesTar(path))
    command = "tar -xf " + file;
  else if (!packing->is_archive)
    command += " > " + shellWord(unpackedName(path).string());
  return "is " + std::string(packing->name) + "; unpack it first: " + command;
}

}  // namespace lode
