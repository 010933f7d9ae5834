#include "common/io/foreign_file.h"

#include <algorithm>
#include <array>
#include <cctype>

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

/// Returns the words for a compressed file or an archive.
std::optional<std::string> packedInWords(const std::filesystem::path& path, std::string_view head) {
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

/// Describes how users convert a format to PLY.
struct Conversion {
  std::string_view programs;  ///< programs that read the format and write PLY
  bool has_assimp = true;     ///< true if the command assimp converts it, too
};

/// A mesh format with a signature.
struct ForeignMesh {
  std::string_view magic, name;
  Conversion conversion;
};

constexpr Conversion kByMost{"MeshLab, Blender"}, kByMeshLab{"MeshLab"}, kByBlender{"Blender"},
    kByBlenderAlone{"Blender", false}, kByFreeCad{"FreeCAD", false};

constexpr std::array kForeignMeshes{
    ForeignMesh{"glTF"sv, "a GLB (binary glTF)", kByMost},
    ForeignMesh{"Kaydara FBX Binary"sv, "an FBX", kByBlender},
    ForeignMesh{"; FBX "sv, "an FBX", kByBlender},
    ForeignMesh{"#VRML V"sv, "a VRML", {"MeshLab", false}},
    ForeignMesh{"PXR-USDC"sv, "a USD", kByBlenderAlone},
    ForeignMesh{"#usda "sv, "a USD", kByBlenderAlone},
    ForeignMesh{"BLENDER"sv, "a Blender file", kByBlenderAlone},
    ForeignMesh{"ISO-10303-21"sv, "a STEP", kByFreeCad},
};

/// A format that has no mesh to convert.
struct ForeignFormat {
  std::string_view magic, name;
};

constexpr std::array kPointClouds{
    ForeignFormat{"LASF"sv, "a LAS"},
    ForeignFormat{"ASTM-E57"sv, "an E57"},
    ForeignFormat{"# .PCD"sv, "a PCD"},
};

constexpr std::array kPictures{
    ForeignFormat{"\x89PNG"sv, "a PNG"},
    ForeignFormat{"\xff\xd8\xff"sv, "a JPEG"},
    ForeignFormat{"GIF8"sv, "a GIF"},
    ForeignFormat{"II*\0"sv, "a TIFF"},
    ForeignFormat{"MM\0*"sv, "a TIFF"},
    ForeignFormat{"\x76\x2f\x31\x01"sv, "an OpenEXR"},
    ForeignFormat{"#?RADIANCE"sv, "a Radiance"},
    ForeignFormat{"DDS "sv, "a DDS"},
};

constexpr std::string_view kNeither = ", neither a PLY file nor a store; ";

/// Finds the entry of a table whose signature is at the start of the file. Returns null if there is none.
template <class Formats>
const typename Formats::value_type* formatOf(const Formats& formats, std::string_view head) {
  const auto found =
      std::ranges::find_if(formats, [&](const auto& each) { return head.starts_with(each.magic); });
  return found == formats.end() ? nullptr : &*found;
}

std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool contains(std::string_view text, std::string_view part) { return text.find(part) != text.npos; }

/// Returns true if the bytes are text in ASCII or one of its extensions.
bool isText(std::string_view head) {
  return std::ranges::none_of(head, [](unsigned char c) { return c < ' ' && !std::isspace(c); });
}

std::string meshInWords(const std::filesystem::path& path, std::string_view name, const Conversion& way) {
  std::filesystem::path converted = path;
  converted.replace_extension(lowerCase(path.extension().string()) == ".ply" ? "converted.ply" : ".ply");
  std::string words = "is " + std::string(name) + std::string(kNeither) +
                      "Lodestream reads PLY: convert it (" + std::string(way.programs);
  if (way.has_assimp)
    words += ", `assimp export " + shellWord(path.string()) + " " + shellWord(converted.string()) + "`";
  return words + ")";
}

/// Returns the words for meshes in zip archives.
std::optional<std::string> zippedMeshInWords(const std::filesystem::path& path, std::string_view head,
                                             const std::string& ending) {
  if (!head.starts_with("PK\x03\x04")) return std::nullopt;
  if (ending == ".3mf" || contains(head, "3D/3dmodel.model")) return meshInWords(path, "a 3MF", kByMeshLab);
  if (ending == ".usdz") return meshInWords(path, "a USD", kByBlenderAlone);
  return std::nullopt;
}

/// Returns true if the first word of a text is the keyword of an OFF file.
bool beginsAsOff(std::string_view text) {
  constexpr std::array kKeywords{"OFF"sv, "COFF"sv, "NOFF"sv, "CNOFF"sv, "STOFF"sv};
  const std::string_view word = text.substr(0, text.find_first_of(" \t\r\n#"));
  return word.size() < text.size() && std::ranges::find(kKeywords, word) != kKeywords.end();
}

/// Returns the words for meshes whose files have no signature.
std::optional<std::string> unsignedMeshInWords(const std::filesystem::path& path, std::string_view head,
                                               const std::string& ending) {
  const bool is_solid = head.starts_with("solid") && contains(head, "facet");
  if (is_solid || ending == ".stl") return meshInWords(path, "an STL", kByMost);
  if (!isText(head)) return std::nullopt;
  const std::string_view text = head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size()));
  if (beginsAsOff(text) || ending == ".off") return meshInWords(path, "an OFF", kByMeshLab);
  if (text.starts_with("{") && (ending == ".gltf" || contains(text, "\"asset\"")))
    return meshInWords(path, "a glTF", kByMost);
  if (text.starts_with("<") && contains(text, "<COLLADA")) return meshInWords(path, "a COLLADA", kByMost);
  if (ending == ".obj") return meshInWords(path, "an OBJ", kByMost);
  return std::nullopt;
}

std::optional<std::string> pictureInWords(std::string_view head, const std::string& ending) {
  const ForeignFormat* const picture = formatOf(kPictures, head);
  std::string_view name = picture != nullptr ? picture->name : ""sv;
  if (head.starts_with("RIFF") && head.substr(std::min<size_t>(8, head.size())).starts_with("WEBP"))
    name = "a WebP";
  if (head.starts_with("BM") && ending == ".bmp") name = "a BMP";
  if (name.empty()) return std::nullopt;
  return "is " + std::string(name) + " picture" + std::string(kNeither) + "name the PLY file of the mesh";
}

/// Returns the words for text files that stand for another file.
std::optional<std::string> substituteInWords(std::string_view head) {
  if (head.starts_with("version https://git-lfs"))
    return "is a Git LFS pointer, not the file itself; fetch the file with: git lfs pull";
  const std::string start = lowerCase(std::string(head.substr(0, 64)));
  const std::string_view text =
      std::string_view(start).substr(std::min(start.find_first_not_of(" \t\r\n"), start.size()));
  if (text.starts_with("<!doctype html") || text.starts_with("<html"))
    return "is a web page" + std::string(kNeither) + "download the file that the page offers";
  return std::nullopt;
}

}  // namespace

std::optional<std::string> foreignFileInWords(const std::filesystem::path& path, std::string_view head) {
  head = head.substr(0, kForeignHeadBytes);
  if (head.empty()) return "is empty; copy or export it again";
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (head.starts_with(kByteOrderMark)) head.remove_prefix(kByteOrderMark.size());
  if (head.starts_with("ply") || head.starts_with("LODE\r\n")) return std::nullopt;
  const std::string ending = lowerCase(path.extension().string());
  if (auto words = substituteInWords(head)) return words;
  if (auto words = zippedMeshInWords(path, head, ending)) return words;
  if (auto words = packedInWords(path, head)) return words;
  if (const ForeignMesh* const mesh = formatOf(kForeignMeshes, head))
    return meshInWords(path, mesh->name, mesh->conversion);
  if (const ForeignFormat* const cloud = formatOf(kPointClouds, head))
    return "is " + std::string(cloud->name) + " point cloud" + std::string(kNeither) +
           "make a mesh of its points first (MeshLab, CloudCompare)";
  if (auto words = pictureInWords(head, ending)) return words;
  return unsignedMeshInWords(path, head, ending);
}

}  // namespace lode
