# `cmake --install BUILD --component library`: headers, archives and the CMake package isosplat.
# None of them contains the path of the folder in which it was built or first installed.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

if(TARGET isosplat_library)
  set(package ${CMAKE_INSTALL_LIBDIR}/cmake/isosplat)
  install(TARGETS isosplat_library isosplat_library_files EXPORT isosplat
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/shared/core/include/isosplat
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)
  install(FILES ${PROJECT_BINARY_DIR}/include/isosplat/version.h
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/isosplat COMPONENT library)
  install(FILES shared/bindings/library/README.md
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libisosplat-dev COMPONENT library)
  install(DIRECTORY docs/examples/points/
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libisosplat-dev/examples COMPONENT library)
  install(EXPORT isosplat NAMESPACE isosplat:: FILE isosplat-targets.cmake
          DESTINATION ${package} COMPONENT library)
  configure_package_config_file(
    ${CMAKE_CURRENT_LIST_DIR}/isosplat-config.cmake.in
    ${PROJECT_BINARY_DIR}/isosplat-config.cmake INSTALL_DESTINATION ${package})
  # Before 1.0 a new minor version may change the interface.
  write_basic_package_version_file(
    ${PROJECT_BINARY_DIR}/isosplat-config-version.cmake VERSION ${PROJECT_VERSION}
    COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/isosplat-config.cmake
                ${PROJECT_BINARY_DIR}/isosplat-config-version.cmake
          DESTINATION ${package} COMPONENT library)
endif()
