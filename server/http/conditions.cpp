#include "server/http/conditions.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include <arpa/inet.h>

namespace lode::http {

namespace {

std::string_view trim(std::string_view text) noexcept {
  const size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

/// Removes the part before the next separator from `rest` and returns this part without spaces around it.
std::string_view takePart(std::string_view& rest, char separator) noexcept {
  const size_t end = rest.find(separator);
  const std::string_view part = trim(rest.substr(0, end));
  rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  return part;
}

bool equalsIgnoringCase(std::string_view text, std::string_view lower) noexcept {
  return std::ranges::equal(text, lower, {},
                            [](char c) { return c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c; });
}

/// Parses a number of decimal digits. @return nothing for other text and for numbers above 2^64 - 1.
std::optional<uint64_t> parseNumber(std::string_view text) noexcept {
  uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return number;
}

/// Returns true unless a weight such as "q=0" or "q=0.000" refuses the coding.
bool hasWeight(std::string_view parameters) noexcept {
  while (!parameters.empty()) {
    std::string_view value = takePart(parameters, ';');
    if (!equalsIgnoringCase(takePart(value, '='), "q")) continue;
    return value.find_first_of("123456789") != std::string_view::npos;
  }
  return true;
}

bool isLoopbackV4(std::string_view host) noexcept {
  char text[INET_ADDRSTRLEN] = {};
  in_addr address{};
  if (host.size() >= sizeof text) return false;
  host.copy(text, host.size());
  return inet_pton(AF_INET, text, &address) == 1 && ntohl(address.s_addr) >> 24 == IN_LOOPBACKNET;
}

}  // namespace

bool matchesAny(std::string_view field, std::string_view etag) noexcept {
  while (!field.empty()) {
    std::string_view part = takePart(field, ',');
    if (part == "*") return true;
    if (part.starts_with("W/")) part.remove_prefix(2);
    if (part == etag) return true;
  }
  return false;
}

bool acceptsGzip(std::string_view field) noexcept {
  std::optional<bool> any;
  while (!field.empty()) {
    std::string_view part = takePart(field, ',');
    const std::string_view coding = takePart(part, ';');
    if (equalsIgnoringCase(coding, "gzip") || equalsIgnoringCase(coding, "x-gzip")) return hasWeight(part);
    if (coding == "*") any = hasWeight(part);
  }
  return any.value_or(false);
}

std::optional<std::string_view> bearerToken(std::string_view field) noexcept {
  constexpr std::string_view kScheme = "bearer";
  const size_t space = field.find(' ');
  if (space == std::string_view::npos || !equalsIgnoringCase(field.substr(0, space), kScheme)) return {};
  return trim(field.substr(space));
}

bool isSameOrigin(std::string_view origin, std::string_view host) noexcept {
  if (origin.empty()) return true;
  for (const auto& [scheme, port] : {std::pair("http://", ":80"), std::pair("https://", ":443")}) {
    if (!origin.starts_with(scheme)) continue;
    const auto plain = [port = std::string_view(port)](std::string_view place) {
      return place.ends_with(port) ? place.substr(0, place.size() - port.size()) : place;
    };
    const std::string_view from = plain(origin.substr(std::string_view(scheme).size())), to = plain(host);
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c; };
    return std::ranges::equal(from, to, {}, lower, lower);
  }
  return false;
}

bool isLoopbackHost(std::string_view host) noexcept {
  if (host.empty()) return true;
  const size_t colon = host.rfind(':');
  if (colon != std::string_view::npos && host.find(']', colon) == std::string_view::npos)
    host = host.substr(0, colon);
  return equalsIgnoringCase(host, "localhost") || host == "[::1]" || isLoopbackV4(host);
}

ContentRange parseRange(std::string_view field, uint64_t total_bytes) noexcept {
  const ContentRange whole{RangeKind::kWhole, 0, total_bytes};
  std::string_view unit = takePart(field, '=');
  if (!equalsIgnoringCase(unit, "bytes") || field.find(',') != std::string_view::npos) return whole;
  const size_t dash = field.find('-');
  if (dash == std::string_view::npos) return whole;
  const std::string_view from = trim(field.substr(0, dash)), to = trim(field.substr(dash + 1));
  const std::optional<uint64_t> first = parseNumber(from), last = parseNumber(to);
  if ((!from.empty() && !first) || (!to.empty() && !last) || (!first && !last)) return whole;
  if (!first) {  // the last bytes of the content
    const uint64_t bytes = std::min(*last, total_bytes);
    if (bytes == 0) return {RangeKind::kNotSatisfiable, 0, 0};
    return {RangeKind::kPart, total_bytes - bytes, bytes};
  }
  if (last && *last < *first) return whole;
  if (*first >= total_bytes) return {RangeKind::kNotSatisfiable, 0, 0};
  const uint64_t end = last ? std::min(*last, total_bytes - 1) + 1 : total_bytes;
  return {RangeKind::kPart, *first, end - *first};
}

}  // namespace lode::http
