# Sets of precompiled headers, each compiled by its own target. lode_target() uses the set that its
# PRECOMPILED names. The sets only save time: every file includes what it uses, and
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds without them.

set(LODE_STD_HEADERS
  <algorithm> <array> <atomic> <bit> <chrono> <cmath> <cstddef> <cstdint> <cstdio> <cstring> <filesystem> <fstream> <functional>
  <limits> <map> <memory> <mutex> <optional> <random> <set> <span> <string> <string_view> <thread> <unordered_map> <utility>
  <vector> <glm/glm.hpp>)

# lode_precompiled(SET HEADERS headers... LIBRARIES external... [OPTIONS options...]) makes a set's target. A compiler accepts
# a set only with the options that it was compiled with, so OPTIONS apply to every target that uses it.
function(lode_precompiled set)
  cmake_parse_arguments(arg "" "" "HEADERS;LIBRARIES;OPTIONS" ${ARGN})
  set(target precompiled_${set})
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
  lode_compile_options(${target})
  target_compile_options(${target} PUBLIC ${arg_OPTIONS})
  target_link_libraries(${target} PRIVATE ${arg_LIBRARIES})
  target_precompile_headers(${target} PRIVATE ${arg_HEADERS})
  # With precompiled headers g++ 12 gives other names to its false alarm on string concatenation (GCC bug 105651).
  target_compile_options(${target} PUBLIC $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow>)
endfunction()

# Options of code whose compilation costs more than its run time. (At -O1 g++ 12 warns of moved optionals.)
set(LODE_LITTLE_OPTIMIZED -O1 -Wno-maybe-uninitialized)
if(LODE_SANITIZE)
  # Optimizing sanitizers' instrumentation takes half of a test file's compile time.
  set(LODE_LITTLE_OPTIMIZED -O0)
endif()

lode_precompiled(std HEADERS ${LODE_STD_HEADERS} LIBRARIES glm::glm)
# CLI11 is not in this set, since its definitions would be compiled into every file.
lode_precompiled(app OPTIONS ${LODE_LITTLE_OPTIMIZED}
  HEADERS ${LODE_STD_HEADERS} <nlohmann/json.hpp> LIBRARIES glm::glm nlohmann_json::nlohmann_json)
