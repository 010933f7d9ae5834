// Tests of lodestreamd verify, as scripts call it.

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "programs.h"
#include "tests/support/bytes.h"
#include "tests/support/work_folder.h"

namespace lode::test {
namespace {

using Json = nlohmann::json;

class Verify : public testing::Test {
 protected:
  void SetUp() override {
    sample(20000, 1, "a.ply");
    ASSERT_EQ(lodestreamd({"build", folder_ / "a.ply", "-o", store_, "--triangles-per-node", "2000"}).status,
              0);
  }
  void sample(int triangles, int seed, const std::string& name) const {
    ASSERT_EQ(lodestreamd({"sample", "asteroid", "--triangles", std::to_string(triangles), "--seed",
                           std::to_string(seed), "-o", folder_ / name})
                  .status,
              0);
  }
  Outcome verify(std::vector<std::string> options) const {
    options.insert(options.begin(), {"verify", store_.string()});
    return lodestreamd(options);
  }
  Outcome against(const std::string& name) const {
    return verify({"--against", (folder_ / name).string(), "--json"});
  }

  WorkFolder folder_;
  const std::filesystem::path store_ = folder_ / "a.lode";
};

TEST_F(Verify, acceptsOnlyTheStoresOwnInputForAgainst) {
  const Json sound = Json::parse(against("a.ply").out);
  const Json info = Json::parse(lodestreamd({"info", store_, "--json"}).out);
  EXPECT_TRUE(sound["sound"]);
  EXPECT_EQ(sound["against"]["triangles"], info["triangles"]);
  EXPECT_GT(sound["against"]["lods_sampled"], 5);
  EXPECT_GE(sound["against"]["least_ratio"], 0.8);

  sample(20000, 2, "other.ply");
  const Outcome other = against("other.ply");
  EXPECT_EQ(other.status, 1);
  EXPECT_FALSE(Json::parse(other.out)["sound"]);
}

TEST_F(Verify, givesNoVerdictIfAFileCannotBeRead) {
  writeBytes(folder_ / "cut.ply", readBytes(folder_ / "a.ply").substr(0, 2000));
  for (const char* input : {"missing.ply", "cut.ply"}) {
    const Outcome outcome = against(input);
    EXPECT_EQ(outcome.status, 1) << input;
    EXPECT_EQ(outcome.out, "") << input;
  }
  const Outcome nothing = lodestreamd({"verify", folder_ / "missing.lode", "--json"});
  EXPECT_EQ(nothing.status, 1);
  EXPECT_EQ(nothing.out, "");
}

TEST_F(Verify, callsATruncatedStoreUnsound) {
  writeBytes(store_, readBytes(store_).substr(0, 2000));
  EXPECT_FALSE(Json::parse(verify({"--json"}).out)["sound"]);
}

TEST_F(Verify, hasNoRatiosWhereNothingWasMeasured) {
  sample(100, 1, "small.ply");
  ASSERT_EQ(lodestreamd({"build", folder_ / "small.ply", "-o", store_}).status, 0);
  const Json measured = Json::parse(against("small.ply").out)["against"];
  ASSERT_EQ(measured["lods_sampled"], 0);
  EXPECT_TRUE(measured["least_ratio"].is_null());
  EXPECT_TRUE(measured["median_ratio"].is_null());
}

TEST_F(Verify, measuresTheRequestedNumberOfLodsOrAll) {
  const auto lods = [&](const std::string& count) {
    return Json::parse(verify({"--against", folder_ / "a.ply", "--lods", count, "--json"})
                           .out)["against"]["lods_sampled"]
        .get<int>();
  };
  EXPECT_LE(lods("3"), 3);
  EXPECT_GT(lods("all"), 3);
  for (const char* none : {"0", "-1", "few", "3x"})
    EXPECT_EQ(verify({"--against", folder_ / "a.ply", "--lods", none}).status, 2) << none;
  EXPECT_EQ(verify({"--lods", "3"}).status, 2) << "nothing to measure against";
}

}  // namespace
}  // namespace lode::test
