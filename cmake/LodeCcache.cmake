# Compiles through ccache if it is installed, unless the command line names a launcher. ccache caches files with precompiled
# headers only with -fpch-preprocess and with the sloppiness below.
find_program(LODE_CCACHE ccache)
if(LODE_CCACHE)
  if(NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
      CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${LODE_CCACHE})
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_CXX_FLAGS MATCHES "-fpch-preprocess")
    string(APPEND CMAKE_CXX_FLAGS " -fpch-preprocess")
  endif()
endif()
