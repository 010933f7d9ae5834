#include "client/core/cache/cache_queries.h"

#include <cstdint>

#include <gtest/gtest.h>

namespace lode::core {
namespace {

constexpr uint32_t kBlobBytes = 100;

Request request(uint32_t number) {
  Digest name;
  name.bytes[0] = static_cast<std::byte>(number);
  name.bytes[1] = static_cast<std::byte>(number >> 8);
  name.bytes[2] = static_cast<std::byte>(number >> 16);
  return {{number, kBlobBytes, name}, {BlobKind::kMesh, {kRootKey, number}}};
}

/// Asks without a limit in bytes.
bool isMissing(CacheQueries& queries, const Request& request) {
  return queries.isMissing(request, UINT64_MAX);
}

TEST(CacheQueries, askForABlobOnlyOnceBeforeTheAnswer) {
  CacheQueries queries;
  EXPECT_FALSE(isMissing(queries, request(1)));
  EXPECT_FALSE(isMissing(queries, request(1)));
  EXPECT_EQ(queries.take().size(), 1u);
  EXPECT_TRUE(queries.take().empty());
  EXPECT_FALSE(queries.idle());
  EXPECT_EQ(queries.finish(request(1).blob, true), request(1).use);
  EXPECT_TRUE(queries.idle());
  EXPECT_FALSE(queries.finish(request(1).blob, true));
}

TEST(CacheQueries, reportABlobAsMissingUntilItArrives) {
  CacheQueries queries;
  isMissing(queries, request(1));
  queries.finish(request(1).blob, false);
  EXPECT_TRUE(isMissing(queries, request(1)));
  queries.arrived(request(1).blob);
  EXPECT_FALSE(isMissing(queries, request(1)));
}

TEST(CacheQueries, areLimitedInNumber) {
  CacheQueries queries;
  for (uint32_t number = 1; number <= kMaxCacheQueries + 10; ++number)
    EXPECT_FALSE(isMissing(queries, request(number)));
  EXPECT_EQ(queries.take().size(), kMaxCacheQueries);
  queries.finish(request(1).blob, true);
  EXPECT_FALSE(isMissing(queries, request(kMaxCacheQueries + 5)));
  EXPECT_EQ(queries.take().size(), 1u);
}

TEST(CacheQueries, areLimitedInTheTotalSizeOfTheirBlobs) {
  constexpr uint64_t kMostBytes = 10 * kBlobBytes;
  CacheQueries queries;
  for (uint32_t number = 1; number <= 20; ++number)
    EXPECT_FALSE(queries.isMissing(request(number), kMostBytes));
  EXPECT_EQ(queries.take().size(), 10u);
  queries.finish(request(1).blob, false);
  for (uint32_t number = 11; number <= 20; ++number) queries.isMissing(request(number), kMostBytes);
  EXPECT_EQ(queries.take().size(), 1u);
}

TEST(CacheQueries, includeOneBlobThatIsLargerThanTheLimit) {
  CacheQueries queries;
  for (uint32_t number = 1; number <= 3; ++number) queries.isMissing(request(number), kBlobBytes / 2);
  EXPECT_EQ(queries.take().size(), 1u);
}

TEST(CacheQueries, forgetMissingBlobsAboveTheLimit) {
  CacheQueries queries;
  for (uint32_t number = 0; number <= kMaxRememberedMisses; ++number) {
    isMissing(queries, request(number));
    queries.finish(request(number).blob, false);
  }
  EXPECT_TRUE(isMissing(queries, request(kMaxRememberedMisses)));
  EXPECT_FALSE(isMissing(queries, request(1)));
}

}  // namespace
}  // namespace lode::core
