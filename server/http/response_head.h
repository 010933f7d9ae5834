#pragma once

#include <cstdint>
#include <ctime>
#include <string>
#include <string_view>

#include "server/http/conditions.h"

namespace lode::http {

/// How long caches may keep a response.
enum class Caching : uint8_t {
  kNever,       ///< errors
  kRevalidate,  ///< revalidate the entity tag before each use
  kForever,     ///< a content that never changes under its name
};

/// First line and header fields of a response.
struct ResponseHead {
  int status = 200;
  std::string_view content_type{};  ///< empty: none
  uint64_t content_bytes = 0;       ///< size of the body, even if it is not sent (HEAD)
  std::string_view etag{};          ///< empty: none
  ContentRange range{};             ///< part of the content, for status 206 and 416
  uint64_t total_bytes = 0;         ///< size of the whole content, for status 206 and 416
  Caching caching = Caching::kNever;
  bool is_private = false;    ///< only the client's own cache may keep the response
  bool has_variants = false;  ///< the content also exists with or without gzip
  bool is_gzip = false;
  bool closes = false;       ///< the server closes the connection after this response
  std::string_view extra{};  ///< more fields, each with its CRLF
};

/// Returns the bytes of a head with its empty line. Every head has CORS fields, so that pages of other hosts
/// can read the response, and fields with the content security policy.
/// @param now  time for the field Date. Thread safe.
std::string formatHead(const ResponseHead& head, std::time_t now);

/// Fields of the answer to a preflight request (https://fetch.spec.whatwg.org/#cors-preflight-fetch).
constexpr std::string_view kPreflightFields =
    "Access-Control-Allow-Methods: GET, HEAD, OPTIONS\r\n"
    "Access-Control-Allow-Headers: Authorization, If-None-Match, If-Range, Range\r\n"
    "Access-Control-Max-Age: 86400\r\n"
    "Allow: GET, HEAD, OPTIONS\r\n";
constexpr std::string_view kAllowField = "Allow: GET, HEAD, OPTIONS\r\n";
constexpr std::string_view kBearerField = "WWW-Authenticate: Bearer\r\n";
constexpr std::string_view kWebSocketField =
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n";
constexpr std::string_view kRetryField = "Retry-After: 1\r\n";

}  // namespace lode::http
