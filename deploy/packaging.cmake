# What `cmake --install` and `cpack` make: the package dcloc (programs, unit, manual, completion) and
# libdcloc-dev (the client library, for find_package(dcloc)).
include(GNUInstallDirs)

# ---- Programs
install(TARGETS dcloc dcloc-server RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
install(FILES deploy/dcloc-server.service DESTINATION lib/systemd/system COMPONENT programs)
install(DIRECTORY deploy/monitoring
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT programs)
install(FILES deploy/haproxy.cfg
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT programs)
# Not with the documentation, which small images leave out: postinst copies it.
install(FILES deploy/server.json DESTINATION ${CMAKE_INSTALL_DATADIR}/dcloc COMPONENT programs)
install(FILES LICENSE README.md CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT programs)

# The programs describe themselves, so that manual and completion cannot say anything else.
install(CODE "
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/described)
  execute_process(COMMAND $<TARGET_FILE:dcloc> manual
    OUTPUT_FILE ${CMAKE_BINARY_DIR}/described/dcloc.1 COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND $<TARGET_FILE:dcloc> completion
    OUTPUT_FILE ${CMAKE_BINARY_DIR}/described/dcloc COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:dcloc-server>
    -DOUTPUT=${CMAKE_BINARY_DIR}/described/dcloc-server.8
    -P ${CMAKE_SOURCE_DIR}/deploy/server_manual.cmake COMMAND_ERROR_IS_FATAL ANY)"
  COMPONENT programs)
install(FILES ${CMAKE_BINARY_DIR}/described/dcloc-server.8
  DESTINATION ${CMAKE_INSTALL_MANDIR}/man8 COMPONENT programs)
install(FILES ${CMAKE_BINARY_DIR}/described/dcloc.1
  DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT programs)
install(FILES ${CMAKE_BINARY_DIR}/described/dcloc
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT programs)

# ---- The client library. Includes are written from the root, so the headers keep their folders.
set(SDK_HEADERS admin_client channel map_client map_upload recording session session_options
  session_stats)
list(TRANSFORM SDK_HEADERS PREPEND client/sdk/)
list(TRANSFORM SDK_HEADERS APPEND .h)
install(FILES ${SDK_HEADERS}
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/dcloc/client/sdk COMPONENT sdk)
install(FILES client/sdk/pose/pose_estimate.h client/sdk/pose/rigid_pose.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/dcloc/client/sdk/pose COMPONENT sdk)
install(DIRECTORY ${CMAKE_BINARY_DIR}/proto/generated/dcloc
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/dcloc COMPONENT sdk FILES_MATCHING PATTERN "*.pb.h")
install(DIRECTORY proto/dcloc
  DESTINATION ${CMAKE_INSTALL_DATADIR}/dcloc/proto COMPONENT sdk FILES_MATCHING PATTERN "*.proto")
install(TARGETS dcloc_client dcloc_sdk_pose dcloc_proto
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sdk)
include(CMakePackageConfigHelpers)
configure_package_config_file(deploy/dclocConfig.cmake.in ${CMAKE_BINARY_DIR}/dclocConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/dcloc
  PATH_VARS CMAKE_INSTALL_INCLUDEDIR CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_DATADIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/dclocConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/dclocConfig.cmake ${CMAKE_BINARY_DIR}/dclocConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/dcloc COMPONENT sdk)
install(DIRECTORY client/sdk/example DESTINATION ${CMAKE_INSTALL_DATADIR}/dcloc COMPONENT sdk)

# ---- Debian packages
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME dcloc)
set(CPACK_PACKAGE_CONTACT "the dcloc authors <dcloc@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Localizes vehicles by automotive radar")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL programs sdk)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME dcloc)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS gnuplot-nox)
set(CPACK_DEBIAN_PROGRAMS_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION_SUMMARY}
 The server, its systemd unit, and the command line that makes maps, localizes,
 simulates and evaluates.")
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_CONTROL_EXTRA
  ${CMAKE_SOURCE_DIR}/deploy/debian/postinst ${CMAKE_SOURCE_DIR}/deploy/debian/postrm
  ${CMAKE_SOURCE_DIR}/deploy/debian/prerm)
set(CPACK_DEBIAN_SDK_PACKAGE_NAME libdcloc-dev)
set(CPACK_DEBIAN_SDK_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_SDK_PACKAGE_DEPENDS
  "libgrpc++-dev, libprotobuf-dev, libabsl-dev, libssl-dev, zlib1g-dev")
set(CPACK_DEBIAN_SDK_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION_SUMMARY} (client library)
 What a vehicle links to be localized by a dcloc server: find_package(dcloc).")
include(${CMAKE_CURRENT_LIST_DIR}/console.cmake)
include(CPack)
