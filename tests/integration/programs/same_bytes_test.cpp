// The bytes of a store depend only on the input and the options (I6), not on the compiler, the libraries or
// the system's release.

#include <gtest/gtest.h>

#include "tests/integration/programs/programs.h"

namespace lode::test {
namespace {

// Update this value only with an intended change of the store's bytes; the failing test prints the new value.
// Any other failure is a defect: compare `lodestreamd info --nodes` of two stores.
constexpr const char* kSha256 = "5ae9a4786b0673276bc6eee79aa641680fdfedbcc1bf846950305fb0f3b82fd1";

TEST(SameBytes, storesOfSamplesHaveTheirRecordedHashes) {
  const WorkFolder folder;
  const std::filesystem::path store = makeSmallStore(folder);
  const std::string said = Program("sha256sum", {store.string()}).wait().out;
  EXPECT_EQ(said.substr(0, said.find(' ')), kSha256);
}

}  // namespace
}  // namespace lode::test
