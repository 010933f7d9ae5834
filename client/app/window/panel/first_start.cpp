#include "client/app/window/panel/first_start.h"

#include <system_error>
#include <utility>

#include "common/error.h"
#include "common/io/own_folder.h"

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
  try {
    makeOwnFolders(folder_, {"the cache", "set XDG_CACHE_HOME"});
    writeOwnFile(folder_ / kSeenName, {});
  } catch (const Error&) {  // the help appears again at the next start
  }
}

}  // namespace lode::app
