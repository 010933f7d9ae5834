#include "server/http/listing.h"

#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace lode::http {
namespace {

using Json = nlohmann::json;

ModelSummary summaryOf(const std::string& name) {
  ModelSummary summary;
  summary.name = name;
  summary.lattice = {.origin = {100, 200, 5e6}, .step = 0.5};
  summary.box = {.min = {0, 2, 4}, .max = {10, 20, 30}};
  summary.triangles = 7;
  return summary;
}

TEST(ModelsJson, placesModelsAtTheirOwnCoordinates) {
  const Json json = Json::parse(modelsJson(std::vector{summaryOf("a b")}, {}));
  const Json& model = json["models"].at(0);
  EXPECT_EQ(model["name"], "a b");
  EXPECT_EQ(model["tileset"], "a%20b/tileset.json");
  EXPECT_EQ(model["triangles"], 7);
  EXPECT_EQ(model["box"], (Json{{100.0, 201.0, 5000002.0}, {105.0, 210.0, 5000015.0}}));
  EXPECT_EQ(model["size"], (Json{5.0, 9.0, 13.0}));
}

TEST(ModelsJson, namesTheNativePortOnlyIfItIsReached) {
  EXPECT_TRUE(Json::parse(modelsJson({}, {})).at("native").is_null());
  EXPECT_EQ(Json::parse(modelsJson({}, NativePort{7400, true}))["native"],
            (Json{{"port", 7400}, {"tls", true}}));
}

TEST(IndexPage, linksEveryTilesetAndEscapesNames) {
  const std::string page = indexPage(std::vector{summaryOf("a&<b>")});
  EXPECT_NE(page.find("<a href=\"a%26%3Cb%3E/tileset.json\">a&amp;&lt;b&gt;</a>: 7 triangles"), page.npos)
      << page;
  EXPECT_NE(indexPage({}).find("no model"), std::string::npos);
}

}  // namespace
}  // namespace lode::http
