# Installs files beside the programs, and makes Debian packages of them.
#   cmake --build BUILD --target programs && cmake --install BUILD --component programs --prefix WHERE
#   cmake --build BUILD && cpack --config BUILD/CPackConfig.cmake     packages lodestream, lodestreamd, liblodestream-dev

set(packaging ${CMAKE_CURRENT_LIST_DIR}/packaging)

# lode_install(PACKAGE install-arguments...) installs with the component programs and into the component of a package.
function(lode_install package)
  install(${ARGN} COMPONENT programs)
  install(${ARGN} COMPONENT ${package} EXCLUDE_FROM_ALL)
endfunction()

# Installs for both programs: the program, its man page, its completion and the licence.
set(man_pages)
foreach(program lodestream lodestreamd)
  set(page ${PROJECT_BINARY_DIR}/${program}.1)
  add_custom_command(OUTPUT ${page}
    COMMAND ${packaging}/make_man_page.sh $<TARGET_FILE:${program}> ${PROJECT_VERSION} ${packaging}/${program}.man > ${page}
    DEPENDS ${program} ${packaging}/make_man_page.sh ${packaging}/${program}.man
    COMMENT "Making ${program}.1"
    VERBATIM)
  list(APPEND man_pages ${page})
  lode_install(${program} TARGETS ${program} RUNTIME)
  lode_install(${program} FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  lode_install(${program} FILES ${packaging}/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    RENAME ${program})
  lode_install(${program} FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${program} RENAME copyright)
endforeach()
add_custom_target(programs ALL DEPENDS lodestream lodestreamd ${man_pages})

lode_install(lodestreamd FILES ${packaging}/lodestreamd.service DESTINATION lib/systemd/system)
lode_install(lodestreamd FILES ${packaging}/public.conf DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/lodestreamd/examples)
lode_install(lodestream FILES ${packaging}/lodestream.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages)
lode_install(lodestream FILES ${packaging}/lodestream.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
if(LODE_GL)  # other builds cannot open a window
  lode_install(lodestream FILES ${packaging}/lodestream.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/liblodestream-dev RENAME copyright
  COMPONENT embed)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "Lodestream <lodestream@localhost>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL lodestream lodestreamd embed)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)

# lode_package(COMPONENT NAME SECTION SUMMARY TEXT) sets the metadata of a component's package.
function(lode_package component name section summary text)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
endfunction()

lode_package(lodestream lodestream graphics "viewer of meshes that stream from a server"
  "Shows PLY meshes of any size and stores of Lodestream, from files or from\nservers, and refines the picture while it receives data.")
lode_package(lodestreamd lodestreamd net "server of meshes in levels of detail"
  "Turns PLY meshes of any size into octrees of simplified meshes, and serves\nthem over TCP. Contains a unit of systemd, which is not enabled.")
lode_package(embed liblodestream-dev libdevel "client of Lodestream for other programs"
  "A static library with a header for C and C++, files for CMake and pkg-config,\nand two examples.")

# dpkg-shlibdeps finds the libraries that programs link; libepoxy loads libEGL and libGL at run time.
set(CPACK_DEBIAN_LODESTREAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LODESTREAMD_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LODESTREAM_PACKAGE_RECOMMENDS "lodestreamd (= ${PROJECT_VERSION})")
if(LODE_GL)
  set(CPACK_DEBIAN_LODESTREAM_PACKAGE_DEPENDS "libegl1, libgl1")
  string(APPEND CPACK_DEBIAN_LODESTREAM_PACKAGE_RECOMMENDS ", fonts-dejavu-core, libgl1-mesa-dri")
  set(CPACK_DEBIAN_LODESTREAM_PACKAGE_SUGGESTS ffmpeg)
endif()
set(CPACK_DEBIAN_EMBED_PACKAGE_DEPENDS "libdraco-dev, libjpeg-dev, libssl-dev, libwebp-dev, libxxhash-dev")
set(CPACK_DEBIAN_LODESTREAMD_PACKAGE_CONTROL_EXTRA
  ${packaging}/debian/postinst ${packaging}/debian/prerm ${packaging}/debian/postrm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
