#include "server/http/route.h"

#include <gtest/gtest.h>

namespace lode::http {
namespace {

const std::string kHex = "0123456789abcdef0123456789abcdef";

Resource resourceOf(const std::string& target) { return parseTarget(target).resource; }

TEST(Route, findsEveryResource) {
  EXPECT_EQ(resourceOf("/"), Resource::kIndex);
  EXPECT_EQ(resourceOf("/models.json"), Resource::kModels);
  EXPECT_EQ(resourceOf("/ws"), Resource::kWebSocket);
  const Route tileset = parseTarget("/a/tileset.json?v=1#x");
  EXPECT_EQ(tileset.resource, Resource::kTileset);
  EXPECT_EQ(tileset.model, "a");
  EXPECT_EQ(tileset.file, "tileset.json");
  const Route page = parseTarget("/a/p/" + kHex + ".json");
  EXPECT_EQ(page.resource, Resource::kTilesetPage);
  EXPECT_EQ(page.file, "p/" + kHex + ".json");
  const Route tile = parseTarget("https://here:1/a/g/" + kHex + ".1.glb");
  EXPECT_EQ(tile.resource, Resource::kTile);
  EXPECT_EQ(tile.model, "a");
  EXPECT_EQ(tile.file, "g/" + kHex + ".1.glb");
}

TEST(Route, findsFilesOfThePage) {
  EXPECT_EQ(parseTarget("/").file, "index.html");
  const Route route = parseTarget("/core.wasm?v=1");
  EXPECT_EQ(route.resource, Resource::kPageFile);
  EXPECT_EQ(route.file, "core.wasm");
  EXPECT_EQ(route.model, "");
  const Route behind_token = parseTarget("/t/x/app.js");
  EXPECT_EQ(behind_token.resource, Resource::kPageFile);
  EXPECT_EQ(behind_token.file, "app.js");
  EXPECT_EQ(behind_token.token, "x");
  for (const char* const target : {"/app/", "/app/a/b", "/a/app.js"})
    EXPECT_EQ(resourceOf(target), Resource::kUnknown) << target;
}

TEST(Route, decodesModelNamesAfterSplitting) {
  EXPECT_EQ(parseTarget("/a%20b%C3%A4/tileset.json").model, "a bä");
  EXPECT_EQ(parseTarget("/a%2fb/tileset.json").model, "a/b");
  EXPECT_EQ(resourceOf("/a/b/tileset.json"), Resource::kUnknown);
  EXPECT_EQ(parseTarget("/" + percentEncode("a/b %?#&é") + "/tileset.json").model, "a/b %?#&é");
}

TEST(Route, takesATokenFromThePath) {
  const Route route = parseTarget("/t/se%2Fcret/a/g/" + kHex + ".1.glb");
  EXPECT_EQ(route.resource, Resource::kTile);
  EXPECT_EQ(route.model, "a");
  EXPECT_EQ(route.token, "se/cret");
  EXPECT_EQ(parseTarget("/t/x/").resource, Resource::kIndex);
  EXPECT_EQ(parseTarget("/t/x/models.json").token, "x");
  EXPECT_EQ(resourceOf("/t/x"), Resource::kUnknown);
}

TEST(Route, findsImagesThatTilesShare) {
  const Route route = parseTarget("/a/i/" + kHex + ".1.webp");
  EXPECT_EQ(route.resource, Resource::kWebp);
  EXPECT_EQ(route.file, "i/" + kHex + ".1.webp");
  EXPECT_EQ(resourceOf("/t/x/a/i/" + kHex + ".1.jpg"), Resource::kJpeg);
}

TEST(Route, servesAModelWithTheNameOfThePrefix) {
  EXPECT_EQ(parseTarget("/t/tileset.json").model, "t");
  EXPECT_EQ(parseTarget("/t/p/" + kHex + ".json").model, "t");
  const Route route = parseTarget("/t/x/t/tileset.json");
  EXPECT_EQ(route.model, "t");
  EXPECT_EQ(route.token, "x");
}

TEST(Route, refusesMalformedTargets) {
  for (const char* const target : {"", "*", "a", "/%", "/%4", "/%zz", "/a%00b/tileset.json", "/\xff/x",
                                   "/%ff/x", "/%0a/tileset.json", "here:80", "//%e"})
    EXPECT_EQ(resourceOf(target), Resource::kMalformed) << target;
}

TEST(Route, findsNothingOutsideTheTilesets) {
  for (const std::string target :
       {"//", "/../etc/passwd", "/a/../b/tileset.json", "/%2e%2e/%2e%2e/etc/passwd", "/a/p/../../x",
        "/a/p/x.json", "/a/g/0123.glb", "/a/q/", "/a/b/c/d/e/f/g/h", "/models.json/"})
    EXPECT_EQ(resourceOf(target), Resource::kUnknown) << target;
  EXPECT_EQ(resourceOf("/a/p/" + kHex + ".glb"), Resource::kUnknown);
  EXPECT_EQ(resourceOf("/a/i/" + kHex + ".glb"), Resource::kUnknown);
  EXPECT_EQ(resourceOf("/a/g/" + kHex + ".jpg"), Resource::kUnknown);
  EXPECT_EQ(resourceOf("/a/g/" + kHex + ".json"), Resource::kUnknown);
}

}  // namespace
}  // namespace lode::http
