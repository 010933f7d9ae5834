#include "server/serve/ops/health_request.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace lode::serve {
namespace {

TEST(HealthRequest, isAwaitedUntilItsHeadIsComplete) {
  const std::string request = "GET /metrics?x=1 HTTP/1.1\r\nHost: here\r\n\r\n";
  for (size_t length = 0; length < request.size(); ++length)
    EXPECT_FALSE(parseHealthRequest(std::string_view(request).substr(0, length)));
  const auto parsed = parseHealthRequest(request);
  ASSERT_TRUE(parsed);
  EXPECT_EQ(parsed->path, "/metrics");
  EXPECT_TRUE(parsed->known_method);
  EXPECT_FALSE(parsed->head_only);
}

TEST(HealthRequest, tellsMethodsApart) {
  EXPECT_TRUE(parseHealthRequest("HEAD /healthz HTTP/1.0\r\n\r\n")->head_only);
  EXPECT_FALSE(parseHealthRequest("POST /healthz HTTP/1.1\r\n\r\n")->known_method);
}

TEST(HealthRequest, thatIsNotHttpOrTooLongIsRefused) {
  for (const char* text : {"hello\r\n\r\n", "GET /\r\n\r\n", "GET / LODE/1\r\n\r\n", "\r\n\r\n"})
    EXPECT_THROW(parseHealthRequest(text), Error) << text;
  EXPECT_THROW(parseHealthRequest(std::string(kMaxHealthRequestBytes, 'x')), Error);
  EXPECT_FALSE(parseHealthRequest(std::string(kMaxHealthRequestBytes - 1, 'x')));
}

TEST(HealthAnswer, hasItsLengthAndEndsTheConnection) {
  const std::string answer = healthAnswer(503, "text/plain", "stopping\n", false);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 503 Service Unavailable\r\n"));
  EXPECT_NE(answer.find("\r\nContent-Length: 9\r\n"), std::string::npos);
  EXPECT_NE(answer.find("\r\nConnection: close\r\n"), std::string::npos);
  EXPECT_TRUE(answer.ends_with("\r\n\r\nstopping\n"));
  EXPECT_TRUE(healthAnswer(200, "text/plain", "alive\n", true).ends_with("\r\n\r\n"));
}

}  // namespace
}  // namespace lode::serve
