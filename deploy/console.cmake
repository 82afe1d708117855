# The package dcloc-console: what client/console/build made, its systemd unit and its settings. It is
# there where DCLOC_CONSOLE_DIST names that folder, as cmake needs no Node otherwise:
#   client/console/build && cmake --preset release -DDCLOC_CONSOLE_DIST=$PWD/build/console/dist
set(DCLOC_CONSOLE_DIST "" CACHE PATH "Folder of the built console, to be packaged; empty: none")
if(DCLOC_CONSOLE_DIST)
  if(NOT EXISTS ${DCLOC_CONSOLE_DIST}/dcloc-console.cjs)
    message(FATAL_ERROR "DCLOC_CONSOLE_DIST: ${DCLOC_CONSOLE_DIST} has no dcloc-console.cjs")
  endif()
  install(DIRECTORY ${DCLOC_CONSOLE_DIST}/ DESTINATION lib/dcloc-console COMPONENT console)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/dcloc-console.service
    DESTINATION lib/systemd/system COMPONENT console)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/debian/console/default
    DESTINATION /etc/default RENAME dcloc-console COMPONENT console)
  list(APPEND CPACK_COMPONENTS_ALL console)
  set(CPACK_DEBIAN_CONSOLE_PACKAGE_NAME dcloc-console)
  set(CPACK_DEBIAN_CONSOLE_PACKAGE_SECTION web)
  set(CPACK_DEBIAN_CONSOLE_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_CONSOLE_PACKAGE_DEPENDS "nodejs (>= 18)")
  set(CPACK_DEBIAN_CONSOLE_PACKAGE_CONTROL_EXTRA
    ${CMAKE_CURRENT_LIST_DIR}/debian/console/conffiles
    ${CMAKE_CURRENT_LIST_DIR}/debian/console/postinst)
  set(CPACK_DEBIAN_CONSOLE_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION_SUMMARY} (web console)
 A page that shows the fleet, its maps, and why a vehicle is lost, and the process
 that serves it.")
endif()
