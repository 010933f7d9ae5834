#include "client/app/window/panel/first_start.h"

#include <fstream>
#include <system_error>
#include <utility>

namespace lode::app {
namespace {

constexpr const char* kSeenName = "help-seen";

}  // namespace

FirstStart::FirstStart(std::filesystem::path folder) : folder_(std::move(folder)) {}

bool FirstStart::isHelpDue() const {
  std::error_code ignored;
  return !std::filesystem::exists(folder_ / kSeenName, ignored);
}

void FirstStart::helpWasSeen() const {
  std::error_code ignored;
  std::filesystem::create_directories(folder_, ignored);
  std::ofstream(folder_ / kSeenName);
}

}  // namespace lode::app
