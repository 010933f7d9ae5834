#include "server/http/route.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "common/printable.h"

namespace lode::http {

namespace {

/// Number of segments of the longest route, "t/TOKEN/MODEL/p/PAGE.json".
constexpr size_t kMostSegments = 5;
constexpr std::string_view kIndexFile = "index.html";

int digitOf(char digit) noexcept {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  if (digit >= 'A' && digit <= 'F') return digit - 'A' + 10;
  return -1;
}

/// Returns the path of "/path?query" or of "http://host/path", or nothing for other targets.
std::optional<std::string_view> pathOf(std::string_view target) {
  for (const std::string_view scheme : {"http://", "https://"})
    if (target.starts_with(scheme)) {
      const size_t slash = target.find('/', scheme.size());
      target = slash == std::string_view::npos ? "/" : target.substr(slash);
    }
  if (!target.starts_with('/')) return {};
  return target.substr(0, target.find_first_of("?#"));
}

/// Splits a path at its slashes. @return nothing if a segment is malformed; no segment if there are more than
/// kMostSegments.
std::optional<std::vector<std::string>> segmentsOf(std::string_view path) {
  std::vector<std::string> segments;
  path.remove_prefix(1);
  while (true) {
    const size_t slash = path.find('/');
    std::optional<std::string> segment = percentDecode(path.substr(0, slash));
    if (!segment || !isPrintableUtf8(*segment)) return {};
    if (segments.size() == kMostSegments) return std::vector<std::string>();
    segments.push_back(std::move(*segment));
    if (slash == std::string_view::npos) return segments;
    path.remove_prefix(slash + 1);
  }
}

/// Files of a tileset below tileset.json.
struct FileKind {
  std::string_view folder, extension;
  Resource resource;
};
constexpr std::array<FileKind, 4> kFileKinds{{{"p", ".json", Resource::kTilesetPage},
                                              {"g", ".glb", Resource::kTile},
                                              {"i", ".jpg", Resource::kJpeg},
                                              {"i", ".webp", Resource::kWebp}}};

bool isHexName(std::string_view name) {
  constexpr size_t kDigits = 32;
  return name.size() >= kDigits && name.find_first_not_of("0123456789abcdef") >= kDigits;
}

/// Finds the resource that the segments after the token name. Sets every member of the route except the
/// token.
void findResource(std::span<const std::string> segments, Route& route) {
  const std::string& last = segments.back();
  if (segments.size() == 1) {
    route = {Resource::kPageFile, {}, last, {}};
    if (last.empty()) route = {Resource::kIndex, {}, std::string(kIndexFile), {}};
    if (last == "models.json") route.resource = Resource::kModels;
    if (last == "ws") route = {Resource::kWebSocket, {}, {}, {}};
  } else if (segments.size() == 2 && last == "tileset.json") {
    route = {Resource::kTileset, segments[0], last, {}};
  } else if (segments.size() == 3 && isHexName(last)) {
    for (const FileKind& kind : kFileKinds)
      if (segments[1] == kind.folder && last.ends_with(kind.extension))
        route = {kind.resource, segments[0], segments[1] + "/" + last, {}};
  }
}

}  // namespace

std::optional<std::string> percentDecode(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? digitOf(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? digitOf(text[i + 2]) : -1;
    if (high < 0 || low < 0) return {};
    decoded += static_cast<char>(high << 4 | low);
    i += 2;
  }
  return decoded;
}

std::string percentEncode(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF", kPlain = "-._~";
  std::string encoded;
  for (const char c : text) {
    const bool is_plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          kPlain.find(c) != std::string_view::npos;
    if (is_plain) {
      encoded += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      encoded += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  return encoded;
}

Route parseTarget(std::string_view target) {
  Route route;
  const std::optional<std::string_view> path = pathOf(target);
  const auto segments = path ? segmentsOf(*path) : std::nullopt;
  if (!segments) {
    route.resource = Resource::kMalformed;
    return route;
  }
  if (segments->empty()) return route;
  findResource(*segments, route);
  if (route.resource != Resource::kUnknown || segments->size() < 3 || segments->front() != "t") return route;
  findResource(std::span(*segments).subspan(2), route);
  route.token = (*segments)[1];
  return route;
}

}  // namespace lode::http
