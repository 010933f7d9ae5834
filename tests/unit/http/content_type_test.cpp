#include "server/http/content_type.h"

#include <gtest/gtest.h>

namespace lode::http {
namespace {

TEST(ContentType, isWhatBrowsersRequire) {
  EXPECT_EQ(contentTypeOf("index.html"), "text/html; charset=utf-8");
  EXPECT_EQ(contentTypeOf("app.js"), "text/javascript; charset=utf-8");
  EXPECT_EQ(contentTypeOf("style.css"), "text/css; charset=utf-8");
  EXPECT_EQ(contentTypeOf("core.wasm"), "application/wasm");
}

TEST(ContentType, isThatOfTheFilesOfTilesets) {
  EXPECT_EQ(contentTypeOf("tileset.json"), "application/json");
  EXPECT_EQ(contentTypeOf("g/0123.1.glb"), "model/gltf-binary");
  EXPECT_EQ(contentTypeOf("i/0123.1.jpg"), "image/jpeg");
  EXPECT_EQ(contentTypeOf("i/0123.1.webp"), "image/webp");
}

TEST(ContentType, ofOtherFilesIsNoTypeThatBrowsersRun) {
  for (const char* const name : {"", "wasm", "a.exe", "a.js.gz"})
    EXPECT_EQ(contentTypeOf(name), "application/octet-stream") << name;
}

}  // namespace
}  // namespace lode::http
