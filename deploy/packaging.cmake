# What `cmake --install` and `cpack` make, a package for each component:
# programs: dcloc (programs, unit, manuals, completion);
# c:        libdcloc1 (the C interface's shared library);
# c_dev:    libdcloc-dev (its header, pkg-config, find_package(dcloc-c));
# sdk:      libdcloc++-dev (the C++ library, find_package(dcloc)).
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
  execute_process(COMMAND $<TARGET_FILE:dcloc> completion zsh
    OUTPUT_FILE ${CMAKE_BINARY_DIR}/described/_dcloc COMMAND_ERROR_IS_FATAL ANY)
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
install(FILES ${CMAKE_BINARY_DIR}/described/_dcloc
  DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT programs)

# ---- The C interface
install(TARGETS dcloc_sdk_c EXPORT dcloc-c
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT c NAMELINK_COMPONENT c_dev)
install(FILES client/sdk/c/dcloc.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT c_dev)
file(RELATIVE_PATH PREFIX_FROM_PKGCONFIG /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(client/sdk/c/dcloc.pc.in ${CMAKE_BINARY_DIR}/dcloc.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/dcloc.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT c_dev)
install(EXPORT dcloc-c NAMESPACE dcloc:: FILE dcloc-cConfig.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/dcloc-c COMPONENT c_dev)
install(FILES ${CMAKE_BINARY_DIR}/dclocConfigVersion.cmake RENAME dcloc-cConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/dcloc-c COMPONENT c_dev)
install(DIRECTORY client/sdk/c/example/
  DESTINATION ${CMAKE_INSTALL_DATADIR}/dcloc/example-c COMPONENT c_dev)

# ---- The C++ library. Includes are written from the root, so the headers keep their folders.
set(SDK_HEADERS admin_client channel map_client map_upload recording requests session session_options
  session_stats)
list(TRANSFORM SDK_HEADERS PREPEND client/sdk/)
list(TRANSFORM SDK_HEADERS APPEND .h)
install(FILES ${SDK_HEADERS}
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/dcloc/client/sdk COMPONENT sdk)
install(FILES client/sdk/pose/motion_signals.h client/sdk/pose/pose_estimate.h client/sdk/pose/rigid_pose.h
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
set(CPACK_COMPONENTS_ALL programs c c_dev sdk)
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
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_C_PACKAGE_NAME libdcloc1)
set(CPACK_DEBIAN_C_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_C_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_C_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION_SUMMARY} (C interface)
 The shared library that vehicles, and the Python package, call.")
set(CPACK_DEBIAN_C_DEV_PACKAGE_NAME libdcloc-dev)
set(CPACK_DEBIAN_C_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_C_DEV_PACKAGE_DEPENDS "libdcloc1 (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_C_DEV_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION_SUMMARY} (C interface, header)
 What a vehicle's program in C is built with: dcloc.h, pkg-config dcloc, find_package(dcloc-c).")
set(CPACK_DEBIAN_SDK_PACKAGE_NAME libdcloc++-dev)
set(CPACK_DEBIAN_SDK_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_SDK_PACKAGE_DEPENDS
  "libgrpc++-dev, libprotobuf-dev, libabsl-dev, libssl-dev, zlib1g-dev")
set(CPACK_DEBIAN_SDK_PACKAGE_REPLACES "libdcloc-dev (<= 0.1.0)")  # its name until then
set(CPACK_DEBIAN_SDK_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION_SUMMARY} (C++ library)
 What a vehicle's program in C++ is built with: find_package(dcloc).")
include(${CMAKE_CURRENT_LIST_DIR}/console.cmake)
include(CPack)
