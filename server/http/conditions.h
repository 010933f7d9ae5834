#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace lode::http {

/// Returns true if a field If-None-Match names an entity tag. Ignores "W/" (RFC 9110, 8.8.3.2).
/// @param field  the field's value; empty: false. @param etag  a strong tag with its quotes.
bool matchesAny(std::string_view field, std::string_view etag) noexcept;

/// Returns true if the client accepts gzip by its field Accept-Encoding (RFC 9110, 12.5.3).
bool acceptsGzip(std::string_view field) noexcept;

/// Returns the token of a field Authorization, "Bearer TOKEN" (RFC 6750, 2.1), or nothing for other schemes.
std::optional<std::string_view> bearerToken(std::string_view field) noexcept;

/// Returns true if the fields Origin and Host name the same host and port, so that the page may open a
/// WebSocket. Port 80 or 443 may be left out. Clients other than browsers send no origin, and the function
/// returns true.
bool isSameOrigin(std::string_view origin, std::string_view host) noexcept;

/// Returns true if a field Host names this machine itself: localhost, 127.0.0.0/8 or [::1], with any port.
/// Without a field the client is no browser, and the function returns true. In a DNS rebinding attack, the
/// name of another host resolves to loopback, but Host contains that name.
bool isLoopbackHost(std::string_view host) noexcept;

enum class RangeKind : uint8_t { kWhole, kPart, kNotSatisfiable };

/// Range of bytes that a request asks for.
struct ContentRange {
  RangeKind kind = RangeKind::kWhole;
  uint64_t first = 0, bytes = 0;
};

/// Parses the field Range (RFC 9110, 14.1.2). Several ranges and other units select the whole content.
/// @param field  the field's value, or empty. @param total_bytes  size of the content.
ContentRange parseRange(std::string_view field, uint64_t total_bytes) noexcept;

}  // namespace lode::http
