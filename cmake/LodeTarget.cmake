# Declares targets with C++20, warnings, sanitizers and the layers of docs/architecture.md.

# LODE_LAYER_<name> lists the layers that a library of that layer may use.
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/layers.txt lines REGEX "^[a-z_]+ *\\| [^|]*\\|")
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/layers.txt)
foreach(line ${lines})
  if(line MATCHES "^([a-z_]+) *\\|[^|]*\\|(.*)$")
    set(name ${CMAKE_MATCH_1})
    string(STRIP "${CMAKE_MATCH_2}" allowed)
    separate_arguments(LODE_LAYER_${name} UNIX_COMMAND "${allowed}")
  endif()
endforeach()

# Warnings are errors with g++ 12, which CI uses, and with clang. New or false warnings of other compilers, and of
# instrumented code, never end a build.
set(LODE_WARNINGS -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wno-restrict)
if(NOT LODE_SANITIZE AND (NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU" OR CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13))
  list(APPEND LODE_WARNINGS -Werror)
endif()

# lode_compile_options(NAME) sets the options of every file.
function(lode_compile_options name)
  target_compile_features(${name} PUBLIC cxx_std_20)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF)
  # -Wrestrict: false alarms on string concatenation in g++ 12 (GCC bug 105651).
  # -ffp-contract=off: stores and computed normals are the same on machines with fused multiply-add.
  target_compile_options(${name} PRIVATE ${LODE_WARNINGS} -ffp-contract=off)
  if(CMAKE_UNITY_BUILD)
    # g++ treats an included source as a header and warns of its anonymous namespaces.
    target_compile_options(${name} PRIVATE -Wno-subobject-linkage)
  endif()
  if(LODE_SANITIZE)
    # With sanitizers g++ 12 falsely reports uninitialized values, such as moved optionals.
    target_compile_options(${name} PRIVATE -fsanitize=${LODE_SANITIZE} -fno-omit-frame-pointer -Wno-maybe-uninitialized)
  endif()
endfunction()

# lode_target(NAME [EXECUTABLE] [SOURCES files...] [LAYERS layers...] [LIBRARIES external...] [PUBLIC_LIBRARIES external...]
#             [PRECOMPILED set])
#   NAME         lode_<layer> for a library; its sources are the *.cpp in and below its folder unless SOURCES names them
#   LAYERS       the layers that it uses; a layer that its own may not use is a configure error
#   PRECOMPILED  a set of cmake/LodePrecompiled.cmake, with its options; std by default
# With CMAKE_UNITY_BUILD the sources of a folder compile as one, in about half the time; a source with a UNITY_GROUP keeps it.
# Commands then use no precompiled set, because a set would cost more than it saves for their three files.
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
