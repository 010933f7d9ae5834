# Sets of headers that are parsed once a build instead of once a file, each compiled by a target of its own; a target of
# lode_target() takes the set that its PRECOMPILED names. They only save time: every file includes what it uses, and
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds the same without them.

set(LODE_STD_HEADERS
  <algorithm> <array> <atomic> <bit> <chrono> <cmath> <cstddef> <cstdint> <cstdio> <cstring> <filesystem> <fstream> <functional>
  <limits> <map> <memory> <mutex> <optional> <random> <set> <span> <string> <string_view> <thread> <unordered_map> <utility>
  <vector> <glm/glm.hpp>)

# lode_precompiled(SET HEADERS headers... LIBRARIES outside... [OPTIONS options...]): the set's target. A compiler takes a set
# only if it was compiled with the same options, so OPTIONS go to all that take it.
function(lode_precompiled set)
  cmake_parse_arguments(arg "" "" "HEADERS;LIBRARIES;OPTIONS" ${ARGN})
  set(target precompiled_${set})
  add_library(${target} OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
  lode_compile_options(${target})
  target_compile_options(${target} PUBLIC ${arg_OPTIONS})
  target_link_libraries(${target} PRIVATE ${arg_LIBRARIES})
  target_precompile_headers(${target} PRIVATE ${arg_HEADERS})
  # g++ 12 gives its false alarm on string concatenation (GCC bug 105651) other names where a header was precompiled.
  target_compile_options(${target} PUBLIC $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow>)
endfunction()

# For what is compiled more often than it runs long. (g++ 12 takes moved optionals for uninitialized at -O1.)
set(LODE_LITTLE_OPTIMIZED -O1 -Wno-maybe-uninitialized)
if(LODE_SANITIZE)
  # What sanitizers add takes longer to optimize than all else: half of the time that a test's file takes.
  set(LODE_LITTLE_OPTIMIZED -O0)
endif()

lode_precompiled(std HEADERS ${LODE_STD_HEADERS} LIBRARIES glm::glm)
# CLI11 is not in this set: what it defines would be compiled into every file.
lode_precompiled(app OPTIONS ${LODE_LITTLE_OPTIMIZED}
  HEADERS ${LODE_STD_HEADERS} <nlohmann/json.hpp> LIBRARIES glm::glm nlohmann_json::nlohmann_json)
