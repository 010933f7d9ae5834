#include "server/serve/memory/trim_watch.h"

#include <fstream>

#include <malloc.h>
#include <unistd.h>

namespace lode::serve {

uint64_t anonymousResidentBytes() {
  std::ifstream pages("/proc/self/statm");
  uint64_t all = 0, resident = 0, of_files = 0;
  if (!(pages >> all >> resident >> of_files)) return 0;
  return (resident - std::min(resident, of_files)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

uint64_t allocatedBytes() {
  const auto told = mallinfo2();
  return told.uordblks + told.hblkhd;
}

}  // namespace lode::serve
