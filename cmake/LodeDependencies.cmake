# Every library from outside, as a target. docs/architecture.md says why each is here; docker/packages.txt installs them.

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
find_package(spdlog REQUIRED)

# Debian's draco package config misses its include folder; the library itself is all that is needed.
find_library(LODE_DRACO_LIBRARY draco REQUIRED)
add_library(lode_draco INTERFACE)
target_link_libraries(lode_draco INTERFACE ${LODE_DRACO_LIBRARY})

# Debian's prometheus-cpp package config asks for what its other parts need; its core is all that is needed.
find_library(LODE_PROMETHEUS_LIBRARY prometheus-cpp-core REQUIRED)
add_library(lode_prometheus INTERFACE)
target_link_libraries(lode_prometheus INTERFACE ${LODE_PROMETHEUS_LIBRARY})

# Asio is headers only. The definitions make clang's tools see the coroutines that g++ sees by itself.
find_path(LODE_ASIO_INCLUDE asio.hpp REQUIRED)
add_library(lode_asio INTERFACE)
target_include_directories(lode_asio SYSTEM INTERFACE ${LODE_ASIO_INCLUDE})
target_compile_definitions(lode_asio INTERFACE ASIO_STANDALONE ASIO_NO_DEPRECATED ASIO_HAS_CO_AWAIT=1 ASIO_HAS_STD_COROUTINE=1)
# Coroutines wait in one another: a thread keeps the frames of as many as a connection has, instead of two. Its memory comes
# from operator new, as all other does, so that the server's reserve is for it too.
target_compile_definitions(lode_asio INTERFACE ASIO_RECYCLING_ALLOCATOR_CACHE_SIZE=8 ASIO_DISABLE_STD_ALIGNED_ALLOC)
target_link_libraries(lode_asio INTERFACE Threads::Threads)
if(LODE_SANITIZE)
  # At their -O1 g++ 12 sees the operator new in a coroutine's frame, but not the delete that goes with it: a false alarm.
  target_compile_options(lode_asio INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-mismatched-new-delete>)
endif()
if(LODE_SANITIZE MATCHES thread)
  # The thread sanitizer does not know fences, and g++ says so. Asio's queues are behind mutexes all the same.
  target_compile_definitions(lode_asio INTERFACE ASIO_DISABLE_FENCED_BLOCK)
endif()

if(LODE_GL)
  find_package(glfw3 REQUIRED)
  pkg_check_modules(epoxy REQUIRED IMPORTED_TARGET epoxy)
  pkg_check_modules(egl REQUIRED IMPORTED_TARGET egl)
  find_path(LODE_IMGUI_INCLUDE imgui/imgui.h REQUIRED)
  find_library(LODE_IMGUI_LIBRARY imgui REQUIRED)
  find_library(LODE_STB_LIBRARY NAMES libstb.a REQUIRED)  # imgui's fonts use it; static, as imgui is
  add_library(lode_imgui INTERFACE)
  target_include_directories(lode_imgui SYSTEM INTERFACE ${LODE_IMGUI_INCLUDE}/imgui)
  target_link_libraries(lode_imgui INTERFACE ${LODE_IMGUI_LIBRARY} ${LODE_STB_LIBRARY} glfw)
endif()
