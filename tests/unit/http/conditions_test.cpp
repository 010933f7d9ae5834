#include "server/http/conditions.h"

#include <gtest/gtest.h>

namespace lode::http {
namespace {

TEST(Conditions, compareEntityTags) {
  EXPECT_TRUE(matchesAny("\"a\"", "\"a\""));
  EXPECT_TRUE(matchesAny("W/\"a\"", "\"a\""));
  EXPECT_TRUE(matchesAny("\"b\" ,\t\"a\"", "\"a\""));
  EXPECT_TRUE(matchesAny("*", "\"a\""));
  for (const char* const field : {"", "\"b\"", "a", "\"a", "\"a\"x", ",,"})
    EXPECT_FALSE(matchesAny(field, "\"a\"")) << field;
}

TEST(Conditions, knowWhoAcceptsGzip) {
  for (const char* const field :
       {"gzip", "br, GZIP", "gzip;q=0.5", "x-gzip", "*", "br;q=1.0, *;q=0.1", "gzip ; q=0.001"})
    EXPECT_TRUE(acceptsGzip(field)) << field;
  for (const char* const field :
       {"", "br", "gzip;q=0", "gzip;q=0.000", "*;q=0", "gzip;q=0, *", "gzipped", "identity"})
    EXPECT_FALSE(acceptsGzip(field)) << field;
}

TEST(Conditions, findABearerToken) {
  EXPECT_EQ(bearerToken("Bearer abc"), "abc");
  EXPECT_EQ(bearerToken("bEARER   a b "), "a b");
  EXPECT_EQ(bearerToken("Bearer "), "");
  for (const char* const field : {"", "Bearer", "Basic abc", "Bearerabc", " Bearer abc"})
    EXPECT_FALSE(bearerToken(field)) << field;
}

TEST(Conditions, compareOrigins) {
  EXPECT_TRUE(isSameOrigin("", "a:80"));
  EXPECT_TRUE(isSameOrigin("http://a", "a"));
  EXPECT_TRUE(isSameOrigin("http://A:8080", "a:8080"));
  EXPECT_TRUE(isSameOrigin("http://a:80", "a"));
  EXPECT_TRUE(isSameOrigin("https://a", "a:443"));
  EXPECT_TRUE(isSameOrigin("http://[::1]:8080", "[::1]:8080"));
  EXPECT_FALSE(isSameOrigin("http://b", "a"));
  EXPECT_FALSE(isSameOrigin("http://a:8081", "a:8080"));
  EXPECT_FALSE(isSameOrigin("http://a.b", "a"));
  EXPECT_FALSE(isSameOrigin("null", "a"));
  EXPECT_FALSE(isSameOrigin("ftp://a", "a"));
  EXPECT_FALSE(isSameOrigin("http://", "a"));
}

TEST(Conditions, knowTheNamesOfThisMachine) {
  for (const char* const host : {"", "localhost", "localhost:8080", "LocalHost:1", "127.0.0.1",
                                 "127.0.0.1:7480", "127.9.8.7:80", "[::1]", "[::1]:8080"})
    EXPECT_TRUE(isLoopbackHost(host)) << host;
}

TEST(Conditions, mistrustNamesThatOthersCanDirectHere) {
  for (const char* const host :
       {"evil.example", "evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example",
        "evillocalhost", "a", "128.0.0.1", "10.0.0.1:80", "0.0.0.0", "127.1", "2130706433", "[::]",
        "[::2]:80", "::1", "localhost:80:80", "127.0.0.1@evil.example", ":8080", "localhost.", " localhost"})
    EXPECT_FALSE(isLoopbackHost(host)) << host;
}

TEST(Conditions, selectARange) {
  const auto part = [](const char* field, uint64_t first, uint64_t bytes) {
    const ContentRange range = parseRange(field, 100);
    EXPECT_EQ(range.kind, RangeKind::kPart) << field;
    EXPECT_EQ(range.first, first) << field;
    EXPECT_EQ(range.bytes, bytes) << field;
  };
  part("bytes=0-0", 0, 1);
  part("bytes=10-19", 10, 10);
  part("Bytes = 10-", 10, 90);
  part("bytes=10-1000", 10, 90);
  part("bytes=99-99", 99, 1);
  part("bytes=-5", 95, 5);
  part("bytes=-500", 0, 100);
  part("bytes=5-18446744073709551615", 5, 95);
}

TEST(Conditions, selectTheWholeContentOtherwise) {
  for (const char* const field : {"", "bytes", "bytes=", "bytes=-", "bytes=a-b", "bytes=1-2,4-5", "lines=1-2",
                                  "bytes=5-4", "bytes=1-99999999999999999999", "bytes=+1-2", "bytes=--1"}) {
    const ContentRange range = parseRange(field, 100);
    EXPECT_EQ(range.kind, RangeKind::kWhole) << field;
    EXPECT_EQ(range.bytes, 100) << field;
  }
}

TEST(Conditions, refuseRangesBeyondTheContent) {
  EXPECT_EQ(parseRange("bytes=100-", 100).kind, RangeKind::kNotSatisfiable);
  EXPECT_EQ(parseRange("bytes=-0", 100).kind, RangeKind::kNotSatisfiable);
  EXPECT_EQ(parseRange("bytes=0-0", 0).kind, RangeKind::kNotSatisfiable);
  EXPECT_EQ(parseRange("bytes=-1", 0).kind, RangeKind::kNotSatisfiable);
}

}  // namespace
}  // namespace lode::http
