// Measures distances of simplified surfaces from their originals, and differences of pictures.

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <span>
#include <string_view>

#include "tests/bench/fidelity_parts.h"

namespace {

constexpr const char* kUsage =
    "usage: bench_fidelity ORIGINAL.ply CUT.ply...                two-sided distances\n"
    "       bench_fidelity --equal-error ORIGINAL.ply CUT.ply...  triangles at equal error\n"
    "       bench_fidelity --pictures FULL.png OTHER.png...       pairs of pictures\n"
    "       bench_fidelity --pictures-halved N FULL.png OTHER.png...  of so many times halved ones\n";

/// @return false if the arguments do not match the usage.
bool runPart(std::span<char* const> arguments) {
  if (arguments.size() < 2) return false;
  const std::string_view part = arguments[0];
  if (part == "--equal-error" && arguments.size() > 2) {
    lode::bench::compareAtEqualError(arguments[1], arguments.subspan(2));
  } else if (part == "--pictures" && arguments.size() % 2 == 1) {
    lode::bench::comparePictures(arguments.subspan(1), 0);
  } else if (part == "--pictures-halved" && arguments.size() % 2 == 0) {
    lode::bench::comparePictures(arguments.subspan(2), std::atoi(arguments[1]));
  } else if (!part.starts_with("--")) {
    lode::bench::compareCuts(arguments[0], arguments.subspan(1));
  } else {
    return false;
  }
  return true;
}

}  // namespace

int main(int count, char** arguments) {
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 12);
  try {
    if (runPart({arguments + 1, arguments + count})) return 0;
    std::fputs(kUsage, stderr);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_fidelity: %s\n", error.what());
    return 1;
  }
}
