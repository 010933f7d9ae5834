#include "client/core/cache/cache_queries.h"

#include <gtest/gtest.h>

namespace lode::core {
namespace {

Request request(uint32_t number) {
  Digest name;
  name.bytes[0] = static_cast<std::byte>(number);
  name.bytes[1] = static_cast<std::byte>(number >> 8);
  name.bytes[2] = static_cast<std::byte>(number >> 16);
  return {{number, 100, name}, {BlobKind::kMesh, {kRootKey, number}}};
}

TEST(CacheQueries, askForABlobOnlyOnceBeforeTheAnswer) {
  CacheQueries queries;
  EXPECT_FALSE(queries.isMissing(request(1)));
  EXPECT_FALSE(queries.isMissing(request(1)));
  EXPECT_EQ(queries.take().size(), 1u);
  EXPECT_TRUE(queries.take().empty());
  EXPECT_FALSE(queries.idle());
  EXPECT_EQ(queries.finish(request(1).blob, true), request(1).use);
  EXPECT_TRUE(queries.idle());
  EXPECT_FALSE(queries.finish(request(1).blob, true));
}

TEST(CacheQueries, reportABlobAsMissingUntilItArrives) {
  CacheQueries queries;
  queries.isMissing(request(1));
  queries.finish(request(1).blob, false);
  EXPECT_TRUE(queries.isMissing(request(1)));
  queries.arrived(request(1).blob);
  EXPECT_FALSE(queries.isMissing(request(1)));
}

TEST(CacheQueries, areLimitedInNumber) {
  CacheQueries queries;
  for (uint32_t number = 1; number <= kMaxCacheQueries + 10; ++number)
    EXPECT_FALSE(queries.isMissing(request(number)));
  EXPECT_EQ(queries.take().size(), kMaxCacheQueries);
  queries.finish(request(1).blob, true);
  EXPECT_FALSE(queries.isMissing(request(kMaxCacheQueries + 5)));
  EXPECT_EQ(queries.take().size(), 1u);
}

TEST(CacheQueries, forgetMissingBlobsAboveTheLimit) {
  CacheQueries queries;
  for (uint32_t number = 0; number <= kMaxRememberedMisses; ++number) {
    queries.isMissing(request(number));
    queries.finish(request(number).blob, false);
  }
  EXPECT_TRUE(queries.isMissing(request(kMaxRememberedMisses)));
  EXPECT_FALSE(queries.isMissing(request(1)));
}

}  // namespace
}  // namespace lode::core
