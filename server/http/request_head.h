#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// The parts of HTTP that need no socket: heads of requests and responses, names of resources, and the
/// contents of responses with their cache. docs/tiles.md describes the server.
namespace lode::http {

constexpr size_t kMaxHeadBytes = 8192;  ///< size of the first line and all header fields of a request

enum class Method : uint8_t { kGet, kHead, kOptions, kOther };

/// Header fields of a request to open a WebSocket (RFC 6455, 4.2.1).
struct WebSocketRequest {
  std::string key, version, origin;
};

/// A request without a body. Fields that a request lacks are empty.
struct RequestHead {
  Method method = Method::kGet;
  std::string target;  ///< as sent: path and query, or an absolute URL
  std::string host, authorization, if_none_match, if_range, range, accept_encoding;
  bool keeps_alive = true;                    ///< the client accepts more responses on this connection
  std::optional<WebSocketRequest> websocket;  ///< set if the request asks for a WebSocket
};

/// Result of parsing a request's head.
struct ParsedHead {
  size_t bytes = 0;        ///< size of the head with its empty line
  int refused_with = 0;    ///< HTTP status that refuses the request, or 0
  std::string_view why{};  ///< reason of the refusal
  RequestHead head;        ///< valid if the request is not refused
};

/// Parses a request's head with Boost.Beast. Refuses requests with a body, ambiguous requests (request
/// smuggling), versions other than HTTP/1.0 and 1.1, and heads above kMaxHeadBytes.
/// @param received  bytes received so far; bytes after the head are ignored.
/// @param searched_bytes  number of leading bytes that earlier calls have searched for the head's end.
/// @return nothing if the head is incomplete. Thread safe.
std::optional<ParsedHead> parseHead(std::string_view received, size_t searched_bytes = 0);

}  // namespace lode::http
