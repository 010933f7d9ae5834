#include "client/core/cache_queries.h"

#include <gtest/gtest.h>

namespace lode::core {
namespace {

Wish wishFor(uint32_t number) {
  BlobName name;
  name.bytes[0] = static_cast<std::byte>(number);
  name.bytes[1] = static_cast<std::byte>(number >> 8);
  return {{number, 100, name}, {BlobKind::kMesh, {kRootKey, number}}};
}

TEST(CacheQueries, askForABlobOnceUntilTheAnswer) {
  CacheQueries queries;
  EXPECT_FALSE(queries.lacks(wishFor(1)));
  EXPECT_FALSE(queries.lacks(wishFor(1)));
  EXPECT_EQ(queries.take().size(), 1u);
  EXPECT_TRUE(queries.take().empty());
  EXPECT_FALSE(queries.idle());
  EXPECT_EQ(queries.finish(wishFor(1).blob, true), wishFor(1).use);
  EXPECT_TRUE(queries.idle());
  EXPECT_FALSE(queries.finish(wishFor(1).blob, true));
}

TEST(CacheQueries, sendABlobThatIsNotThereToTheServerUntilItHasCome) {
  CacheQueries queries;
  queries.lacks(wishFor(1));
  queries.finish(wishFor(1).blob, false);
  EXPECT_TRUE(queries.lacks(wishFor(1)));
  queries.arrived(wishFor(1).blob);
  EXPECT_FALSE(queries.lacks(wishFor(1)));
}

TEST(CacheQueries, waitWhenManyAreUnderWay) {
  CacheQueries queries;
  for (uint32_t number = 1; number <= kMaxCacheQueries + 10; ++number)
    EXPECT_FALSE(queries.lacks(wishFor(number)));
  EXPECT_EQ(queries.take().size(), kMaxCacheQueries);
  queries.finish(wishFor(1).blob, true);
  EXPECT_FALSE(queries.lacks(wishFor(kMaxCacheQueries + 5)));
  EXPECT_EQ(queries.take().size(), 1u);
}

}  // namespace
}  // namespace lode::core
