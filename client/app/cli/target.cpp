#include "client/app/cli/target.h"

#include <array>
#include <fstream>

#include "common/error.h"
#include "common/limits.h"

namespace lode::app {
namespace {

constexpr std::string_view kScheme = "lode://", kTlsScheme = "lodes://";

struct Url {
  bool encrypted = false;
  std::string_view rest;
};

Url splitScheme(std::string_view text) {
  for (const auto scheme : {kScheme, kTlsScheme})
    if (text.starts_with(scheme)) return {scheme == kTlsScheme, text.substr(scheme.size())};
  throw Error(ErrorCode::kUsage,
              "'" + std::string(text) + "' names no server; write lode://HOST[:PORT], or lodes:// with TLS");
}

Target parseFile(std::string_view text) {
  const std::filesystem::path path{text};
  std::error_code failed;
  const auto status = std::filesystem::status(path, failed);
  if (!std::filesystem::exists(status))
    throw Error(ErrorCode::kIo,
                path.string() + ": no such file; a target is lode://HOST[:PORT]/MODEL, a store or a PLY");
  if (std::filesystem::is_directory(status))
    throw Error(ErrorCode::kInput, path.string() + " is a directory; name a store or a PLY in it");
  std::ifstream file(path, std::ios::binary);
  std::array<char, 3> head{};
  if (!file) throw Error(ErrorCode::kIo, path.string() + ": cannot be opened; check its permissions");
  file.read(head.data(), head.size());
  if (std::string_view(head.data(), head.size()) == "ply" || path.extension() == ".ply") return PlyFile{path};
  return StoreFile{path};
}

}  // namespace

Target parseTarget(std::string_view text) {
  if (text.find("://") == std::string_view::npos) return parseFile(text);
  const auto [encrypted, rest] = splitScheme(text);
  const size_t slash = rest.find('/');
  if (slash == std::string_view::npos || slash + 1 == rest.size())
    throw Error(ErrorCode::kUsage,
                "'" + std::string(text) + "' names no model; write lode://HOST[:PORT]/MODEL");
  std::string model(rest.substr(slash + 1));
  if (model.size() > kMaxModelNameBytes || model.find('/') != std::string::npos)
    throw Error(ErrorCode::kUsage, "'" + std::string(text) + "': a model's name has no slash and at most " +
                                       std::to_string(kMaxModelNameBytes) + " bytes");
  return stream::ServedModel{net::parseAddress(rest.substr(0, slash)), std::move(model), encrypted};
}

stream::ServedModel parseServerUrl(std::string_view text) {
  auto [encrypted, rest] = splitScheme(text);
  if (rest.ends_with('/')) rest.remove_suffix(1);
  if (rest.find('/') != std::string_view::npos)
    throw Error(ErrorCode::kUsage, "'" + std::string(text) + "' names a model; write lode://HOST[:PORT]");
  return {net::parseAddress(rest), "", encrypted};
}

}  // namespace lode::app
