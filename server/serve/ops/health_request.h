#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lode::serve {

constexpr size_t kMaxHealthRequestBytes = 8192;

/// The first line of what Prometheus, a balancer or curl asks; nothing else of a request matters here.
struct HealthRequest {
  std::string path;        ///< without what follows a '?'
  bool head_only = false;  ///< HEAD: the answer has no body
  bool known_method = true;
};

/// @param text  what has come so far. @return nothing while the request's head is not complete.
/// @throws Error kProtocol (no HTTP), kLimit. Thread safe.
std::optional<HealthRequest> parseHealthRequest(std::string_view text);

/// A whole answer, after which the connection closes. @param status  200, 404, 405 or 503.
std::string healthAnswer(int status, std::string_view content_type, std::string_view body, bool head_only);

}  // namespace lode::serve
