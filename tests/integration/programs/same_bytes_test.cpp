// The bytes of a store depend only on the input and the options (I6), not on the compiler, the libraries or
// the system's release.

#include <gtest/gtest.h>

#include "tests/integration/programs/programs.h"

namespace lode::test {
namespace {

// Update this value only with an intended change of the store's bytes; the failing test prints the new value.
// Any other failure is a defect: compare `lodestreamd info --nodes` of two stores.
constexpr const char* kSha256 = "217600aaa050ccb0dd261fcd8ce90bb230b24f2237a7817f4d28dc7100ec70aa";

TEST(SameBytes, storesOfSamplesHaveTheirRecordedHashes) {
  const WorkFolder folder;
  const std::filesystem::path store = makeSmallStore(folder);
  const std::string said = Program("sha256sum", {store.string()}).wait().out;
  EXPECT_EQ(said.substr(0, said.find(' ')), kSha256);
}

}  // namespace
}  // namespace lode::test
