# Finds every external library as a target. docs/architecture.md gives the reasons; docker/packages.txt lists the packages.

find_package(Threads REQUIRED)
find_package(glm REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(FlatBuffers REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(xxhash REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(webp REQUIRED IMPORTED_TARGET libwebp)
find_package(JPEG REQUIRED)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(spdlog REQUIRED)

# Debian's draco package config names a missing include folder, so only the library is looked for.
find_library(LODE_DRACO_LIBRARY draco REQUIRED)
add_library(lode_draco INTERFACE)
target_link_libraries(lode_draco INTERFACE ${LODE_DRACO_LIBRARY})

# Debian's prometheus-cpp package config requires the packages of its other parts; only its core is used.
find_library(LODE_PROMETHEUS_LIBRARY prometheus-cpp-core REQUIRED)
add_library(lode_prometheus INTERFACE)
target_link_libraries(lode_prometheus INTERFACE ${LODE_PROMETHEUS_LIBRARY})

# Asio is header-only. The definitions enable coroutines for clang's tools; g++ enables them by itself.
find_path(LODE_ASIO_INCLUDE asio.hpp REQUIRED)
add_library(lode_asio INTERFACE)
target_include_directories(lode_asio SYSTEM INTERFACE ${LODE_ASIO_INCLUDE})
target_compile_definitions(lode_asio INTERFACE ASIO_STANDALONE ASIO_NO_DEPRECATED ASIO_HAS_CO_AWAIT=1 ASIO_HAS_STD_COROUTINE=1)
# A thread recycles the frames of as many nested coroutines as a connection has, instead of two. Frames come from operator
# new, so that the server's memory reserve covers them.
target_compile_definitions(lode_asio INTERFACE ASIO_RECYCLING_ALLOCATOR_CACHE_SIZE=8 ASIO_DISABLE_STD_ALIGNED_ALLOC)
target_link_libraries(lode_asio INTERFACE Threads::Threads)
if(LODE_SANITIZE)
  # At -O1 g++ 12 sees operator new of a coroutine's frame but not its delete: a false alarm.
  target_compile_options(lode_asio INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-mismatched-new-delete>)
endif()
if(LODE_SANITIZE MATCHES thread)
  # The thread sanitizer does not support fences, and g++ warns of it. Asio's queues are behind mutexes anyway.
  target_compile_definitions(lode_asio INTERFACE ASIO_DISABLE_FENCED_BLOCK)
endif()

# Boost.Beast is header-only. Only its parser of HTTP heads is used, not its sockets, which need Boost.Asio beside Asio.
find_path(LODE_BEAST_INCLUDE boost/beast/http/parser.hpp REQUIRED)
add_library(lode_beast INTERFACE)
target_include_directories(lode_beast SYSTEM INTERFACE ${LODE_BEAST_INCLUDE})

if(LODE_GL)
  find_package(glfw3 REQUIRED)
  pkg_check_modules(epoxy REQUIRED IMPORTED_TARGET epoxy)
  pkg_check_modules(egl REQUIRED IMPORTED_TARGET egl)
  find_path(LODE_IMGUI_INCLUDE imgui/imgui.h REQUIRED)
  find_library(LODE_IMGUI_LIBRARY imgui REQUIRED)
  find_library(LODE_STB_LIBRARY NAMES libstb.a REQUIRED)  # for imgui's fonts; static, like imgui
  add_library(lode_imgui INTERFACE)
  target_include_directories(lode_imgui SYSTEM INTERFACE ${LODE_IMGUI_INCLUDE}/imgui)
  target_link_libraries(lode_imgui INTERFACE ${LODE_IMGUI_LIBRARY} ${LODE_STB_LIBRARY} glfw)
endif()
