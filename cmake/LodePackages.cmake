# What is installed beside the programs.
#   cmake --build BUILD --target programs && cmake --install BUILD --component programs --prefix WHERE

set(packaging ${CMAKE_CURRENT_LIST_DIR}/packaging)

# lode_install(PROGRAM install-arguments...) installs a file of a program.
function(lode_install program)
  install(${ARGN} COMPONENT programs)
endfunction()

# Installs what both programs have: the program, its man page, its completion and the licence.
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
