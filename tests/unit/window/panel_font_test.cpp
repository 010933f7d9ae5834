#include "client/app/window/panel/panel_font.h"

#include <gtest/gtest.h>

namespace lode::app {
namespace {

using Ranges = std::vector<uint16_t>;

TEST(PanelCharacters, includeLatinAndTheCharactersOfShownTexts) {
  PanelCharacters characters;
  EXPECT_FALSE(characters.add("Größe 7, Łódź"));
  EXPECT_EQ(characters.ranges<uint16_t>(0xffff), (Ranges{0x20, 0x17f, 0}));
  EXPECT_TRUE(characters.add("Жук Ω 鳥"));
  EXPECT_FALSE(characters.add("Ω"));
  EXPECT_EQ(characters.ranges<uint16_t>(0xffff),
            (Ranges{0x20, 0x17f, 0x3a9, 0x3a9, 0x416, 0x416, 0x43a, 0x43a, 0x443, 0x443, 0x9ce5, 0x9ce5, 0}));
}

TEST(PanelCharacters, excludeCodePointsOutsideTheCharacterType) {
  PanelCharacters characters;
  EXPECT_TRUE(characters.add("\xf0\x9f\x90\x87"));
  EXPECT_EQ(characters.ranges<uint16_t>(0xffff), (Ranges{0x20, 0x17f, 0}));
  EXPECT_EQ(characters.ranges<uint32_t>(0x10ffff), (std::vector<uint32_t>{0x20, 0x17f, 0x1f407, 0x1f407, 0}));
}

TEST(PanelCharacters, ignoreInvalidText) {
  PanelCharacters characters;
  EXPECT_FALSE(characters.add("\xd0"));
  EXPECT_FALSE(characters.add("\xd0z\xff\x80\xe9\xb3"));
}

}  // namespace
}  // namespace lode::app
