#include "server/serve/ops/health_request.h"

#include "common/error.h"

namespace lode::serve {

namespace {

std::string_view reasonOf(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    default:
      return "Service Unavailable";
  }
}

}  // namespace

std::optional<HealthRequest> parseHealthRequest(std::string_view text) {
  if (text.find("\r\n\r\n") == std::string_view::npos) {
    if (text.size() >= kMaxHealthRequestBytes)
      throw Error(ErrorCode::kLimit,
                  "a request longer than " + std::to_string(kMaxHealthRequestBytes) + " bytes");
    return {};
  }
  const std::string_view line = text.substr(0, text.find("\r\n"));
  const size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || first == last || !line.substr(last + 1).starts_with("HTTP/1."))
    throw Error(ErrorCode::kProtocol, "what came to the port of the metrics is not HTTP");
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  return HealthRequest{std::string(target.substr(0, target.find('?'))), method == "HEAD",
                       method == "GET" || method == "HEAD"};
}

std::string healthAnswer(int status, std::string_view content_type, std::string_view body, bool head_only) {
  std::string answer = "HTTP/1.1 " + std::to_string(status) + ' ' + std::string(reasonOf(status)) +
                       "\r\nContent-Type: " + std::string(content_type) +
                       "\r\nContent-Length: " + std::to_string(body.size()) +
                       "\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n";
  return head_only ? answer : answer += body;
}

}  // namespace lode::serve
