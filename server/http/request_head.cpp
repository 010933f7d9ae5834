#include "server/http/request_head.h"

#include <algorithm>

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/rfc7230.hpp>

namespace lode::http {

namespace {

namespace beast = boost::beast;
using Parser = beast::http::request_parser<beast::http::empty_body>;
using Field = beast::http::field;

constexpr std::string_view kEnd = "\r\n\r\n";
constexpr unsigned kHttp11 = 11, kHttp10 = 10;

std::string textOf(const Parser::value_type& message, Field field) {
  const auto found = message.find(field);
  if (found == message.end()) return {};
  return std::string(found->value().data(), found->value().size());
}

Method methodOf(beast::http::verb verb) noexcept {
  switch (verb) {
    case beast::http::verb::get:
      return Method::kGet;
    case beast::http::verb::head:
      return Method::kHead;
    case beast::http::verb::options:
      return Method::kOptions;
    default:
      return Method::kOther;
  }
}

bool asksForWebSocket(const Parser& parser, const Parser::value_type& message) {
  const auto found = message.find(Field::upgrade);
  return parser.upgrade() && found != message.end() &&
         beast::http::token_list(found->value()).exists("websocket");
}

ParsedHead refused(size_t bytes, int status, std::string_view why) { return {bytes, status, why, {}}; }

}  // namespace

std::optional<ParsedHead> parseHead(std::string_view received, size_t searched_bytes) {
  const size_t overlap = std::min(searched_bytes, kEnd.size() - 1);
  const size_t end = received.find(kEnd, searched_bytes - overlap);
  if (end == std::string_view::npos) {
    if (received.size() < kMaxHeadBytes) return {};
    return refused(received.size(), 431, "the head of the request is too long");
  }
  const size_t bytes = end + kEnd.size();
  if (bytes > kMaxHeadBytes) return refused(bytes, 431, "the head of the request is too long");
  Parser parser;
  parser.header_limit(kMaxHeadBytes);
  beast::error_code error;
  parser.put(boost::asio::const_buffer(received.data(), bytes), error);
  if (error == beast::http::error::bad_version) return refused(bytes, 505, "use HTTP/1.1");
  if (error == beast::http::error::body_limit) return refused(bytes, 413, "requests have no body");
  if (error || !parser.is_header_done()) return refused(bytes, 400, "this is not a valid HTTP request");
  const Parser::value_type& message = parser.get();
  if (message.version() != kHttp11 && message.version() != kHttp10)
    return refused(bytes, 505, "use HTTP/1.1");
  if (message.count(Field::host) > 1 || (message.count(Field::host) == 0 && message.version() == kHttp11))
    return refused(bytes, 400, "the request needs one Host field");
  ParsedHead parsed{bytes, 0, {}, {}};
  RequestHead& head = parsed.head;
  head.method = methodOf(message.method());
  if (parser.content_length().value_or(0) > 0 || message.count(Field::transfer_encoding) > 0)
    return refused(bytes, head.method == Method::kOther ? 405 : 413, "requests have no body");
  head.target = std::string(message.target().data(), message.target().size());
  head.host = textOf(message, Field::host);
  head.authorization = textOf(message, Field::authorization);
  head.if_none_match = textOf(message, Field::if_none_match);
  head.if_range = textOf(message, Field::if_range);
  head.range = textOf(message, Field::range);
  head.accept_encoding = textOf(message, Field::accept_encoding);
  head.keeps_alive = parser.keep_alive() && message.version() == kHttp11;
  if (asksForWebSocket(parser, message))
    head.websocket =
        WebSocketRequest{textOf(message, Field::sec_websocket_key),
                         textOf(message, Field::sec_websocket_version), textOf(message, Field::origin)};
  return parsed;
}

}  // namespace lode::http
