#include "common/io/texture_finder.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <system_error>

#include "common/printable.h"

namespace lode {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxTail = 8;  ///< largest number of components in an end of a path (see tailsOf())
constexpr size_t kShownFiles = 3;
constexpr size_t kShownBytes = 4096;  ///< largest number of bytes that a message shows of a path
constexpr std::array<std::string_view, 9> kImageEndings{".png",  ".jpg", ".jpeg", ".webp", ".tif",
                                                        ".tiff", ".bmp", ".tga",  ".gif"};
constexpr const char* kOutside =
    "is outside the PLY file's folder; copy it there, or name its folder with --textures";

/// Looks up a path in a folder. Returns nothing if there is no such file.
std::optional<TextureFile> lookUp(const fs::path& folder, const fs::path& named) {
  std::error_code failed;
  const fs::path path = fs::canonical(folder / named, failed);
  if (failed) return std::nullopt;
  if (!isInside(path, folder))
    return TextureFile{{},
                       named.is_absolute()
                           ? kOutside
                           : "is a link out of the PLY file's folder; copy the image itself there"};
  if (!fs::is_regular_file(path, failed)) return TextureFile{{}, "is not a file; replace it by the image"};
  return TextureFile{path, {}};
}

/// Splits a path of any system. Leaves out empty components and single dots.
std::vector<std::string> componentsOf(std::string_view name) {
  std::vector<std::string> components;
  while (!name.empty()) {
    const size_t end = std::min(name.find_first_of("/\\"), name.size());
    if (const std::string_view component = name.substr(0, end); !component.empty() && component != ".")
      components.emplace_back(component);
    name.remove_prefix(std::min(end + 1, name.size()));
  }
  return components;
}

/// Returns the ends of a path, longest first: for a/b/c, these are a/b/c, b/c and c. No end contains ".." or
/// a hidden component.
std::vector<fs::path> tailsOf(const std::vector<std::string>& components) {
  std::vector<fs::path> tails;
  fs::path tail;
  for (auto at = components.rbegin(); at != components.rend() && tails.size() < kMaxTail; ++at) {
    if (isHidden(*at)) break;
    tail = tail.empty() ? fs::path(*at) : *at / tail;
    tails.push_back(tail);
  }
  std::reverse(tails.begin(), tails.end());
  return tails;
}

bool hasImageEnding(const fs::path& file) {
  return std::ranges::find(kImageEndings, lowerCase(file.extension().string())) != kImageEndings.end();
}

std::string listed(const FolderIndex::Files& files, const fs::path& below) {
  std::string words;
  for (size_t i = 0; i < std::min(files.size(), kShownFiles); ++i)
    words += (i == 0 ? "" : ", ") + quotedText(files[i].lexically_relative(below).string(), kShownBytes);
  if (files.size() > kShownFiles) words += " and " + std::to_string(files.size() - kShownFiles) + " more";
  return words;
}

/// Returns the files with exactly the given name. If there are none, returns the files whose names differ
/// only in the case of letters.
FolderIndex::Files bestMatches(const FolderIndex& index, const std::string& name) {
  const FolderIndex::Files& matches = index.named(name);
  FolderIndex::Files exact;
  std::ranges::copy_if(matches, std::back_inserter(exact),
                       [&](const fs::path& file) { return file.filename() == name; });
  return exact.empty() ? matches : exact;
}

}  // namespace

TextureFinder::TextureFinder(const fs::path& ply, const fs::path& folder)
    : has_texture_folder_(!folder.empty()) {
  std::error_code failed;
  if (has_texture_folder_) addFolder(folder);
  addFolder(ply.has_parent_path() ? ply.parent_path() : ".");
  if (const fs::path target = fs::canonical(ply, failed); !failed) addFolder(target.parent_path());
}

TextureFinder::~TextureFinder() = default;

void TextureFinder::addFolder(const fs::path& folder) {
  std::error_code failed;
  fs::path path = fs::canonical(folder, failed);
  const auto is_same = [&](const Folder& other) { return other.path == path; };
  if (!failed && std::ranges::none_of(folders_, is_same)) folders_.push_back({std::move(path)});
}

const FolderIndex& TextureFinder::indexOf(Folder& folder) {
  if (!folder.index) folder.index = std::make_unique<FolderIndex>(folder.path);
  return *folder.index;
}

TextureFile TextureFinder::find(const std::string& name) {
  if (name.find('\0') != std::string::npos) return {{}, "has a zero byte in its name; correct the name"};
  const std::vector<std::string> components = componentsOf(name);
  std::optional<TextureFile> refused;
  const auto tryIn = [&](const Folder& folder, const fs::path& named) {
    const std::optional<TextureFile> file = lookUp(folder.path, named);
    if (file && !file->problem.empty() && !refused) refused = file;
    return file && file->problem.empty() ? file : std::nullopt;
  };
  const bool goes_up = std::ranges::find(components, "..") != components.end();
  if (!goes_up)
    for (const Folder& folder : folders_)
      if (const auto file = tryIn(folder, name)) return *file;
  for (const Folder& folder : folders_)
    for (const fs::path& tail : tailsOf(components))
      if (const auto file = tryIn(folder, tail)) return *file;
  const std::string last = components.empty() ? std::string() : components.back();
  TextureFile found = search(last);
  return found.path.empty() && refused ? *refused : found;
}

TextureFile TextureFinder::search(const std::string& last_component) {
  for (Folder& folder : folders_) {
    const FolderIndex::Files matches = bestMatches(indexOf(folder), last_component);
    if (matches.size() != 1) continue;
    if (const auto file = lookUp(folder.path, matches.front()); file && file->problem.empty()) return *file;
  }
  return {{}, notFound(last_component)};
}

std::string TextureFinder::notFound(const std::string& last_component) {
  for (Folder& folder : folders_) {
    const FolderIndex& index = indexOf(folder);
    if (const auto matches = bestMatches(index, last_component); !matches.empty())
      return "matches " + counted(matches.size(), "file") + " in " +
             quotedText(folder.path.string(), kShownBytes) + ": " + listed(matches, folder.path) +
             "; give one of them the name in the PLY file, or name its folder with --textures";
    FolderIndex::Files similar = index.withStem(fs::path(last_component).stem().string());
    std::erase_if(similar, [](const fs::path& file) { return !hasImageEnding(file); });
    if (!similar.empty())
      return "was not found, but " + quotedText(folder.path.string(), kShownBytes) + " has " +
             listed(similar, folder.path) + "; if that is the image, name it in the PLY file's header";
  }
  std::string words = "was not found";
  bool is_cut = false;
  for (size_t i = 0; i < folders_.size(); ++i) {
    words += (i == 0                     ? " in "
              : i + 1 == folders_.size() ? " or "
                                         : ", ") +
             quotedText(folders_[i].path.string(), kShownBytes);
    is_cut = is_cut || indexOf(folders_[i]).isCut();
  }
  words += "; put it into the PLY file's folder";
  if (!has_texture_folder_) words += ", or name its folder with --textures";
  if (is_cut)
    words += "; the search ended after " + std::to_string(FolderIndex::kMaxEntries) + " files and folders";
  return words;
}

}  // namespace lode
