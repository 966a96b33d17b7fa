# SPDX-License-Identifier: Apache-2.0
# Installs what no folder's own list does. The lists of the programs' folders install these (bin/).
include(GNUInstallDirs)

# Installs a header of the session library and those that it includes, found by following the includes.
function(tessera_install_headers header)
  set(queue ${header})
  set(found "")
  while(queue)
    list(POP_FRONT queue file)
    if(file IN_LIST found OR NOT EXISTS ${CMAKE_SOURCE_DIR}/${file})
      continue()
    endif()
    list(APPEND found ${file})
    file(STRINGS ${CMAKE_SOURCE_DIR}/${file} lines REGEX "^#include \"")
    foreach(line ${lines})
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
      list(APPEND queue ${included})
    endforeach()
    get_filename_component(folder ${file} DIRECTORY)
    install(FILES ${CMAKE_SOURCE_DIR}/${file}
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tessera/${folder})
  endwhile()
endfunction()
tessera_install_headers(master/session/session.h)
tessera_install_headers(master/session/interactive_loop.h)
tessera_install_headers(master/look/first_look.h)
tessera_install_headers(common/scene/validate.h)
tessera_install_headers(common/viewpoint/scene_overview.h)
tessera_install_headers(common/base/log.h)

file(GLOB units CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/systemd/*.service)
install(FILES ${units} DESTINATION lib/systemd/system)
install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/systemd/tessera.sysusers
        DESTINATION lib/sysusers.d RENAME tessera.conf)
file(GLOB samples CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/config/*.toml
     ${CMAKE_CURRENT_SOURCE_DIR}/metrics/*)
install(FILES ${samples} DESTINATION ${CMAKE_INSTALL_DATADIR}/tessera)
install(PROGRAMS ${CMAKE_CURRENT_SOURCE_DIR}/trace_svg.py DESTINATION ${CMAKE_INSTALL_DATADIR}/tessera)
install(PROGRAMS ${CMAKE_CURRENT_SOURCE_DIR}/launch-slaves.sh
        DESTINATION ${CMAKE_INSTALL_BINDIR} RENAME tessera-launch-slaves)
