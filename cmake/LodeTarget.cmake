# One function a target: C++20, warnings, sanitizers, and the layers of docs/architecture.md.

# LODE_LAYER_<name>: the layers that a library of that layer may use.
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/layers.txt lines REGEX "^[a-z_]+ *\\| [^|]*\\|")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/layers.txt)
foreach(line ${lines})
  if(line MATCHES "^([a-z_]+) *\\|[^|]*\\|(.*)$")
    set(name ${CMAKE_MATCH_1})
    string(STRIP "${CMAKE_MATCH_2}" allowed)
    separate_arguments(LODE_LAYER_${name} UNIX_COMMAND "${allowed}")
  endif()
endforeach()

# Errors with g++ 12, which CI has, and clang: what another compiler newly or falsely warns of ends nobody's build
# (g++ 14, for one: -Wfree-nonheap-object where a vector<bool> is freed), nor what g++ takes for wrong in what a sanitizer
# has added to.
set(LODE_WARNINGS -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wno-restrict)
if(NOT LODE_SANITIZE AND (NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU" OR CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13))
  list(APPEND LODE_WARNINGS -Werror)
endif()

# lode_compile_options(NAME): what every file is compiled with.
function(lode_compile_options name)
  target_compile_features(${name} PUBLIC cxx_std_20)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF)
  # -Wrestrict: false alarms on string concatenation in g++ 12 (GCC bug 105651).
  # Stores, and normals that a reader finds, are the same on machines that fuse multiplications and additions.
  target_compile_options(${name} PRIVATE ${LODE_WARNINGS} -ffp-contract=off)
  if(CMAKE_UNITY_BUILD)
    # g++ takes what a source has for itself for a header's, as it is included.
    target_compile_options(${name} PRIVATE -Wno-subobject-linkage)
  endif()
  if(LODE_SANITIZE)
    # g++ 12 takes what a sanitizer watches for uninitialized, moved optionals for one.
    target_compile_options(${name} PRIVATE -fsanitize=${LODE_SANITIZE} -fno-omit-frame-pointer -Wno-maybe-uninitialized)
  endif()
endfunction()

# lode_target(NAME [EXECUTABLE] [SOURCES files...] [LAYERS layers...] [LIBRARIES outside...] [PUBLIC_LIBRARIES outside...]
#             [PRECOMPILED set])
#   NAME      lode_<layer> for a library; the *.cpp in and below its folder are its sources unless SOURCES names them
#   LAYERS    the layers it may use; a library asking for one that its layer does not allow is a configure error
#   PRECOMPILED  the headers of cmake/LodePrecompiled.cmake that its files need not parse, and the options that go with them
# Where CMAKE_UNITY_BUILD is on (release), the sources of a folder are compiled as one, in about half the time; a source
# that has a UNITY_GROUP keeps it. Each still includes what it uses, as other presets need it to. The commands are then
# three files: a set of headers for them would cost more than it saves.
function(lode_target name)
  cmake_parse_arguments(arg "EXECUTABLE" "PRECOMPILED" "SOURCES;LAYERS;LIBRARIES;PUBLIC_LIBRARIES" ${ARGN})
  if(NOT arg_SOURCES)
    file(GLOB_RECURSE arg_SOURCES CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  endif()
  if(arg_EXECUTABLE)
    add_executable(${name} ${arg_SOURCES})
  else()
    add_library(${name} STATIC ${arg_SOURCES})
    string(REPLACE "lode_" "" layer ${name})
    foreach(used ${arg_LAYERS})
      if(NOT used IN_LIST LODE_LAYER_${layer})
        message(FATAL_ERROR "layer ${layer} must not use layer ${used}: see docs/architecture.md")
      endif()
    endforeach()
  endif()
  lode_compile_options(${name})
  foreach(source ${arg_SOURCES})
    cmake_path(ABSOLUTE_PATH source OUTPUT_VARIABLE folder)
    cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    cmake_path(GET folder PARENT_PATH folder)
    string(REPLACE "/" "_" folder "${folder}")
    get_source_file_property(group ${source} UNITY_GROUP)
    if(NOT group)
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${folder}")
    endif()
  endforeach()
  set_target_properties(${name} PROPERTIES LINKER_LANGUAGE CXX UNITY_BUILD_MODE GROUP)
  target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_include_directories(${name} SYSTEM PUBLIC ${PROJECT_BINARY_DIR}/generated)
  if(LODE_SANITIZE)
    target_link_options(${name} PUBLIC -fsanitize=${LODE_SANITIZE})
  endif()
  if(NOT arg_PRECOMPILED)
    set(arg_PRECOMPILED std)
  endif()
  if(NOT (CMAKE_UNITY_BUILD AND arg_PRECOMPILED STREQUAL "app"))
    target_precompile_headers(${name} REUSE_FROM precompiled_${arg_PRECOMPILED})
  endif()
  target_compile_options(${name} PRIVATE $<TARGET_PROPERTY:precompiled_${arg_PRECOMPILED},INTERFACE_COMPILE_OPTIONS>)
  list(TRANSFORM arg_LAYERS PREPEND lode_)
  target_link_libraries(${name} PUBLIC ${arg_LAYERS} ${arg_PUBLIC_LIBRARIES} PRIVATE ${arg_LIBRARIES})
endfunction()
