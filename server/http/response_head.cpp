#include "server/http/response_head.h"

#include <array>

namespace lode::http {

namespace {

std::string_view reasonOf(int status) noexcept {
  switch (status) {
    case 101:
      return "Switching Protocols";
    case 200:
      return "OK";
    case 204:
      return "No Content";
    case 206:
      return "Partial Content";
    case 304:
      return "Not Modified";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 413:
      return "Content Too Large";
    case 416:
      return "Range Not Satisfiable";
    case 421:
      return "Misdirected Request";
    case 426:
      return "Upgrade Required";
    case 429:
      return "Too Many Requests";
    case 431:
      return "Request Header Fields Too Large";
    case 500:
      return "Internal Server Error";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    default:
      return "Unknown";
  }
}

/// Fields of every response. The policy allows scripts, styles and data only from this server, WebAssembly,
/// and blob images. Pages of other hosts may embed the page.
constexpr std::string_view kCommonFields =
    "Server: lodestreamd\r\n"
    "Access-Control-Allow-Origin: *\r\n"
    "Access-Control-Expose-Headers: Content-Length, Content-Range, ETag\r\n"
    "Timing-Allow-Origin: *\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Content-Security-Policy: default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; "
    "img-src 'self' blob: data:; connect-src 'self'; worker-src 'self'; base-uri 'none'; "
    "form-action 'none'\r\n";

std::string dateOf(std::time_t now) {
  std::tm parts{};
  gmtime_r(&now, &parts);
  constexpr std::array kDays{"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
  constexpr std::array kMonths{"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                               "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const auto two = [](int number) { return std::string{char('0' + number / 10), char('0' + number % 10)}; };
  return std::string(kDays[parts.tm_wday]) + ", " + two(parts.tm_mday) + ' ' + kMonths[parts.tm_mon] + ' ' +
         std::to_string(1900 + parts.tm_year) + ' ' + two(parts.tm_hour) + ':' + two(parts.tm_min) + ':' +
         two(parts.tm_sec) + " GMT";
}

std::string_view cacheControl(const ResponseHead& head) noexcept {
  switch (head.caching) {
    case Caching::kForever:
      return head.is_private ? "private, max-age=31536000, immutable" : "public, max-age=31536000, immutable";
    case Caching::kRevalidate:
      return head.is_private ? "private, no-cache" : "no-cache";
    case Caching::kNever:
      break;
  }
  return "no-store";
}

}  // namespace

std::string formatHead(const ResponseHead& head, std::time_t now) {
  std::string text;
  text.reserve(1024);
  const auto field = [&](std::string_view name, std::string_view value) {
    text.append(name).append(": ").append(value).append("\r\n");
  };
  text.append("HTTP/1.1 ").append(std::to_string(head.status)).append(" ").append(reasonOf(head.status));
  text.append("\r\n");
  field("Date", dateOf(now));
  text.append(kCommonFields);
  field("Cache-Control", cacheControl(head));
  if (!head.content_type.empty()) field("Content-Type", head.content_type);
  if (head.status != 101 && head.status != 204 && head.status != 304)
    field("Content-Length", std::to_string(head.content_bytes));
  if (!head.etag.empty()) {
    field("ETag", head.etag);
    field("Accept-Ranges", "bytes");
  }
  if (head.has_variants) field("Vary", "Accept-Encoding");
  if (head.is_gzip) field("Content-Encoding", "gzip");
  if (head.status == 206)
    field("Content-Range", "bytes " + std::to_string(head.range.first) + "-" +
                               std::to_string(head.range.first + head.range.bytes - 1) + "/" +
                               std::to_string(head.total_bytes));
  if (head.status == 416) field("Content-Range", "bytes */" + std::to_string(head.total_bytes));
  text.append(head.extra);
  if (head.closes) field("Connection", "close");
  text.append("\r\n");
  return text;
}

}  // namespace lode::http
