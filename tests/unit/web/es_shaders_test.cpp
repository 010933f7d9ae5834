#include "client/web/core/es_shaders.h"

#include <string>

#include <gtest/gtest.h>

namespace lode::web {
namespace {

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

TEST(EsShaders, haveNoWordOfDesktopGlslLeft) {
  for (int parts = 0; parts < 16; ++parts) {
    const EsShaders shaders =
        esShaders({(parts & 1) != 0, (parts & 2) != 0, (parts & 4) != 0, (parts & 8) != 0});
    for (const std::string& text : {shaders.vertex, shaders.fragment}) {
      for (const char* word : {"layout(", "CORNER", "buffer ", "table[", "#version"})
        EXPECT_FALSE(contains(text, word)) << parts << " " << word;
    }
  }
}

TEST(EsShaders, passTheSameVariablesBetweenTheStages) {
  for (const bool views : {false, true}) {
    const EsShaders shaders = esShaders({.views = views});
    for (const char* name :
         {"vec3 position_view;", "vec3 normal_view;", "vec2 uv;", "uint material;", "uint flags;"}) {
      const std::string flat = name[0] == 'u' ? "flat " : "";
      EXPECT_TRUE(contains(shaders.vertex, (flat + "out " + name).c_str())) << name;
      EXPECT_TRUE(contains(shaders.fragment, (flat + "in " + name).c_str())) << name;
    }
    EXPECT_EQ(contains(shaders.vertex, "flat out vec3 tint;"), views);
    EXPECT_EQ(contains(shaders.fragment, "flat in vec3 tint;"), views);
  }
}

TEST(EsShaders, readNestedEntriesOfTheTableByTheTexture) {
  const EsShaders shaders = esShaders({.textured = true});
  EXPECT_TRUE(contains(shaders.fragment, "tableAt(tableAt(tableAt(head + 3u) + level) +"));
}

}  // namespace
}  // namespace lode::web
