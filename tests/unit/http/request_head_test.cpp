#include "server/http/request_head.h"

#include <gtest/gtest.h>

namespace lode::http {
namespace {

/// Returns the status that refuses a request, 0 if the request is accepted, or -1 if it is incomplete.
int statusOf(const std::string& text) {
  const auto parsed = parseHead(text);
  return parsed ? parsed->refused_with : -1;
}

TEST(RequestHead, readsTheFieldsThatMatter) {
  const std::string text =
      "GET /a%20b/tileset.json?x HTTP/1.1\r\nhost: here:80\r\nAUTHORIZATION: Bearer abc\r\nif-none-match: "
      "\"e\"\r\n"
      "If-Range: \"r\"\r\nRange: bytes=0-1\r\nAccept-Encoding: gzip, br\r\nX-Other: 1\r\n\r\nGET /next";
  const auto parsed = parseHead(text);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->refused_with, 0);
  EXPECT_EQ(parsed->bytes, text.find("GET /next"));
  const RequestHead& head = parsed->head;
  EXPECT_EQ(head.method, Method::kGet);
  EXPECT_EQ(head.target, "/a%20b/tileset.json?x");
  EXPECT_EQ(head.host, "here:80");
  EXPECT_EQ(head.authorization, "Bearer abc");
  EXPECT_EQ(head.if_none_match, "\"e\"");
  EXPECT_EQ(head.if_range, "\"r\"");
  EXPECT_EQ(head.range, "bytes=0-1");
  EXPECT_EQ(head.accept_encoding, "gzip, br");
  EXPECT_TRUE(head.keeps_alive);
  EXPECT_FALSE(head.websocket);
}

TEST(RequestHead, isIncompleteUntilItsEmptyLine) {
  const std::string text = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";
  for (size_t size = 0; size < text.size(); ++size) {
    EXPECT_EQ(statusOf(text.substr(0, size)), -1) << size;
    EXPECT_TRUE(parseHead(text, size)) << "the end was missed after a search of " << size << " bytes";
  }
  EXPECT_EQ(statusOf(text), 0);
}

TEST(RequestHead, refusesLongHeads) {
  const std::string start = "GET / HTTP/1.1\r\nHost: a\r\nX: ";
  EXPECT_EQ(statusOf(start + std::string(kMaxHeadBytes, 'x')), 431);
  EXPECT_EQ(statusOf(start + std::string(kMaxHeadBytes, 'x') + "\r\n\r\n"), 431);
  const std::string longest = start + std::string(kMaxHeadBytes - start.size() - 4, 'x') + "\r\n\r\n";
  EXPECT_EQ(statusOf(longest), 0);
}

TEST(RequestHead, refusesBodies) {
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhello"), 413);
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost: a\r\nContent-Length: 99999999999\r\n\r\n"), 413);
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"), 413);
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: gzip\r\n\r\n"), 413);
  EXPECT_EQ(statusOf("POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 5\r\n\r\nhello"), 405);
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost: a\r\nContent-Length: 0\r\n\r\n"), 0);
}

TEST(RequestHead, refusesWhatIntermediariesCouldUnderstandInTwoWays) {
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"), 400);
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\n\r\n"), 400);
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost : a\r\n\r\n"), 400);
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost: a\r\nContent-Length: 0\r\nContent-Length: 5\r\n\r\n"), 400);
  EXPECT_EQ(statusOf("GET / HTTP/1.1\r\nHost: a\r\nContent-Length: -1\r\n\r\n"), 400);
  EXPECT_EQ(statusOf(std::string("GET /\0 HTTP/1.1\r\nHost: a\r\n\r\n", 28)), 400);
  EXPECT_EQ(statusOf("GET  HTTP/1.1\r\nHost: a\r\n\r\n"), 400);
  EXPECT_EQ(statusOf("\x16\x03\x01\r\n\r\n"), 400);
}

TEST(RequestHead, refusesOtherVersions) {
  EXPECT_EQ(statusOf("PRI * HTTP/2.0\r\n\r\n"), 505);
  EXPECT_EQ(statusOf("GET / HTTP/1.2\r\nHost: a\r\n\r\n"), 505);
  EXPECT_EQ(statusOf("GET / HTTP/1.0\r\n\r\n"), 0);
}

TEST(RequestHead, knowsWhetherTheConnectionStays) {
  EXPECT_FALSE(parseHead("GET / HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n")->head.keeps_alive);
  EXPECT_FALSE(parseHead("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n")->head.keeps_alive);
}

TEST(RequestHead, knowsWhoAsksForAWebSocket) {
  const auto parsed = parseHead(
      "GET /ws HTTP/1.1\r\nHost: a\r\nConnection: keep-alive, Upgrade\r\nUpgrade: WebSocket\r\n"
      "Sec-WebSocket-Key: k\r\nSec-WebSocket-Version: 13\r\nOrigin: http://a\r\n\r\n");
  ASSERT_TRUE(parsed->head.websocket);
  EXPECT_EQ(parsed->head.websocket->key, "k");
  EXPECT_EQ(parsed->head.websocket->version, "13");
  EXPECT_EQ(parsed->head.websocket->origin, "http://a");
  EXPECT_FALSE(parseHead("GET /ws HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\n\r\n")->head.websocket);
}

}  // namespace
}  // namespace lode::http
