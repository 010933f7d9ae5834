#include "client/app/window/panel/build_stage.h"

#include <algorithm>
#include <array>

namespace lode::app {
namespace {

struct Place {
  std::string_view stage;
  int number;
};

/// In their order: docs/json.md, `--json-progress`.
constexpr std::array kPlaces{Place{"scan", 1},     Place{"textures", 1},  Place{"dereference", 2},
                             Place{"sort", 3},     Place{"partition", 4}, Place{"border", 4},
                             Place{"simplify", 5}, Place{"pack", 6}};

}  // namespace

std::string describeStage(std::string_view stage) {
  const auto* const found = std::ranges::find(kPlaces, stage, &Place::stage);
  if (found == kPlaces.end()) return std::string(stage);
  return std::string(stage) + ", " + std::to_string(found->number) + " of " +
         std::to_string(kPlaces.back().number);
}

}  // namespace lode::app
