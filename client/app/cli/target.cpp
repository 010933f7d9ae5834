#include "client/app/cli/target.h"

#include <array>
#include <fstream>

#include "client/stream/served_model.h"
#include "common/error.h"
#include "common/io/foreign_file.h"

namespace lode::app {
namespace {

Target parseFile(std::string_view text, const std::filesystem::path& textures_folder) {
  const std::filesystem::path path{text};
  if (namesScene(text))
    throw Error(ErrorCode::kUsage,
                path.string() + " is a scene: view and render draw scenes, this command takes one model");
  std::error_code failed;
  const auto status = std::filesystem::status(path, failed);
  if (!std::filesystem::exists(status))
    throw Error(ErrorCode::kIo,
                path.string() + ": no such file; a target is lode://HOST[:PORT]/MODEL, a store or a PLY");
  if (std::filesystem::is_directory(status))
    throw Error(ErrorCode::kInput, path.string() + " is a directory; name a store or a PLY in it");
  if (!std::filesystem::is_regular_file(status))
    throw Error(ErrorCode::kInput, path.string() + " is a pipe or a device; name a file: a store or a PLY");
  std::ifstream file(path, std::ios::binary);
  std::array<char, kForeignHeadBytes> bytes{};
  if (!file) throw Error(ErrorCode::kIo, path.string() + ": cannot be opened; check its permissions");
  file.read(bytes.data(), bytes.size());
  if (file.bad()) throw Error(ErrorCode::kIo, path.string() + ": cannot be read; check the disk");
  const std::string_view head(bytes.data(), static_cast<size_t>(file.gcount()));
  if (const auto foreign = foreignFileInWords(path, head))
    throw Error(ErrorCode::kInput, path.string() + " " + *foreign);
  if (head.starts_with("ply") || path.extension() == ".ply") return PlyFile{path, textures_folder};
  return StoreFile{path};
}

}  // namespace

bool namesScene(std::string_view text) {
  return text.find("://") == std::string_view::npos && text.ends_with(".json");
}

bool looksLikeTarget(std::string_view word) {
  std::error_code failed;
  return word == "-" || word.find_first_of("./") != word.npos ||
         std::filesystem::is_regular_file(word, failed);
}

std::string fullName(std::string_view target) {
  if (target.find("://") != std::string_view::npos) return std::string(target);
  std::error_code failed;
  const std::filesystem::path full =
      std::filesystem::weakly_canonical(std::filesystem::absolute(target, failed), failed);
  return failed ? std::string(target) : full.string();
}

Target parseTarget(std::string_view text, const std::filesystem::path& textures_folder) {
  if (text.find("://") == std::string_view::npos) return parseFile(text, textures_folder);
  return stream::parseServedModel(text);
}

stream::ServedModel parseServerUrl(std::string_view text) { return stream::parseServer(text); }

void refuseToReplace(std::string_view input, const std::filesystem::path& output) {
  std::error_code not_there;
  if (std::filesystem::equivalent(std::filesystem::path(input), output, not_there))
    throw Error(ErrorCode::kUsage, output.string() + ": is the input; name another output");
}

}  // namespace lode::app
