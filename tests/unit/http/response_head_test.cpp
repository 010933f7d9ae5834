#include "server/http/response_head.h"

#include <gtest/gtest.h>

namespace lode::http {
namespace {

bool has(const std::string& head, const std::string& line) {
  return head.find("\r\n" + line + "\r\n") != head.npos;
}

TEST(ResponseHead, hasTheFieldsThatBrowsersNeed) {
  const std::string head = formatHead({.content_type = "model/gltf-binary",
                                       .content_bytes = 12,
                                       .etag = "\"e\"",
                                       .caching = Caching::kForever},
                                      0);
  EXPECT_TRUE(head.starts_with("HTTP/1.1 200 OK\r\nDate: Thu, 01 Jan 1970 00:00:00 GMT\r\n"));
  EXPECT_TRUE(head.ends_with("\r\n\r\n"));
  for (const char* const line :
       {"Content-Type: model/gltf-binary", "Content-Length: 12", "ETag: \"e\"", "Accept-Ranges: bytes",
        "Access-Control-Allow-Origin: *", "Timing-Allow-Origin: *", "X-Content-Type-Options: nosniff",
        "Cache-Control: public, max-age=31536000, immutable"})
    EXPECT_TRUE(has(head, line)) << line;
  EXPECT_FALSE(has(head, "Connection: close"));
}

TEST(ResponseHead, keepsSharedCachesFromPrivateContents) {
  EXPECT_TRUE(has(formatHead({.caching = Caching::kForever, .is_private = true}, 0),
                  "Cache-Control: private, max-age=31536000, immutable"));
  EXPECT_TRUE(has(formatHead({.caching = Caching::kRevalidate}, 0), "Cache-Control: no-cache"));
  EXPECT_TRUE(has(formatHead({.status = 404}, 0), "Cache-Control: no-store"));
}

TEST(ResponseHead, describesARange) {
  const ContentRange range{RangeKind::kPart, 10, 5};
  EXPECT_TRUE(has(formatHead({.status = 206, .range = range, .total_bytes = 100}, 0),
                  "Content-Range: bytes 10-14/100"));
  EXPECT_TRUE(has(formatHead({.status = 416, .total_bytes = 100}, 0), "Content-Range: bytes */100"));
}

TEST(ResponseHead, leavesTheLengthOutIfThereIsNoBody) {
  for (const int status : {204, 304})
    EXPECT_EQ(formatHead({.status = status}, 0).find("\nContent-Length:"), std::string::npos);
}

}  // namespace
}  // namespace lode::http
