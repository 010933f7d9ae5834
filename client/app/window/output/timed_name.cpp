#include "client/app/window/output/timed_name.h"

#include <ctime>

namespace lode::app {

std::string timedName(const std::string& ending) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char name[64];
  std::strftime(name, sizeof name, "lodestream-%Y%m%d-%H%M%S.", &local);
  return name + ending;
}

}  // namespace lode::app
