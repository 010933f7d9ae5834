#include "server/serve/net/admission.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "proto/limits.h"

namespace lode::serve {
namespace {

/// Admits the addresses in order, one connection each. @return for each address whether it was admitted.
std::vector<bool> letIn(Admission& admission, const std::vector<const char*>& addresses,
                        std::vector<Slot>& slots) {
  std::vector<bool> in;
  for (const char* address : addresses) {
    slots.push_back(*admission.enter());
    in.push_back(slots.back().countUnder(asio::ip::make_address(address)));
  }
  return in;
}

TEST(Admission, countsAnIpv6NetworkOf64BitsAsOneAddress) {
  Admission admission(10, 1);
  std::vector<Slot> slots;
  EXPECT_EQ(letIn(admission, {"2001:db8:0:1::1", "2001:db8:0:1:ffff::9", "2001:db8:0:2::1"}, slots),
            std::vector<bool>({true, false, true}));
}

TEST(Admission, countsAnIpv4MappedAddressAsItsIpv4Address) {
  Admission admission(10, 1);
  std::vector<Slot> slots;
  EXPECT_EQ(letIn(admission, {"::ffff:192.0.2.7", "192.0.2.7", "192.0.2.8"}, slots),
            std::vector<bool>({true, false, true}));
}

TEST(Admission, treatsIpv4MappedLoopbackAsLoopback) {
  Admission admission(proto::kMaxConnectionsPerAddress + 1, {});
  std::vector<Slot> slots;
  const std::vector<const char*> addresses(proto::kMaxConnectionsPerAddress + 1, "::ffff:127.0.0.1");
  EXPECT_EQ(std::ranges::count(letIn(admission, addresses, slots), false), 0);
}

TEST(Admission, doesNotMistakeAnIpv6NetworkForAnIpv4Address) {
  Admission admission(10, 1);
  std::vector<Slot> slots;
  EXPECT_EQ(letIn(admission, {"192.0.2.7", "0:0:c000:207::1"}, slots), std::vector<bool>({true, true}));
}

TEST(Admission, countsOnlyOpenConnectionsOfAnAddress) {
  Admission admission(10, 2);
  for (int i = 0; i < 3; ++i) {
    std::vector<Slot> slots;
    EXPECT_EQ(letIn(admission, {"192.0.2.7", "192.0.2.7", "192.0.2.7"}, slots),
              std::vector<bool>({true, true, false}));
    Slot first = std::move(slots.front());
    slots.clear();
    EXPECT_EQ(letIn(admission, {"192.0.2.7", "192.0.2.7"}, slots), std::vector<bool>({true, false}));
  }
  EXPECT_EQ(admission.count(), 0u);
}

TEST(Admission, admitsNoMoreThanItsTotal) {
  Admission admission(1, {});
  const std::optional<Slot> first = admission.enter();
  EXPECT_TRUE(first);
  EXPECT_FALSE(admission.enter());
}

}  // namespace
}  // namespace lode::serve
