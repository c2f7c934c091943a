# Installs the program, the page and their documents, for `cmake --install BUILD --component program`
# and for CPack. `npm run release` makes the packages.
#
#   bin/isosplat                    chooses one of the programs
#   libexec/isosplat/ARCH/isosplat  the program for each instruction set that was built
#   share/isosplat/page             the page
#   share/man, share/bash-completion, share/zsh, share/doc (with examples), lib/systemd
#
# The component library (shared/bindings/library/install.cmake) is a separate Debian package,
# libisosplat-dev, and so is the component python (python.cmake), python3-isosplat. The archive contains
# all components.

set(page ${PROJECT_SOURCE_DIR}/build/page)
set(documents ${PROJECT_BINARY_DIR}/documents)

if(TARGET isosplat_launcher)
  install(TARGETS isosplat DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/isosplat/${ISOSPLAT_ARCH}
          COMPONENT program)
  install(PROGRAMS $<TARGET_FILE:isosplat_launcher> DESTINATION ${CMAKE_INSTALL_BINDIR}
          RENAME isosplat COMPONENT program)
else()
  install(TARGETS isosplat DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()

find_program(HELP2MAN help2man)
add_custom_target(documents
  COMMAND ${PROJECT_SOURCE_DIR}/native/packaging/write-documents $<TARGET_FILE:isosplat> ${documents}
          ${ISOSPLAT_VERSION}
  DEPENDS isosplat COMMENT "Manual pages and changelog")

install(DIRECTORY ${page}/ DESTINATION ${CMAKE_INSTALL_DATADIR}/isosplat/page COMPONENT program)
install(DIRECTORY ${documents}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program)
install(FILES ${documents}/changelog.gz ${documents}/CHANGELOG.md.gz native/packaging/copyright
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/isosplat COMPONENT program)
install(FILES native/packaging/isosplat.bash RENAME isosplat
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
install(FILES native/packaging/isosplat.zsh RENAME _isosplat
        DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT program)
install(FILES native/packaging/copyright
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libisosplat-dev COMPONENT library)
# Debian requires these files. They are optional, so that `cmake --install` of the library works without
# the target `documents`.
install(FILES ${documents}/changelog.gz ${documents}/CHANGELOG.md.gz
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libisosplat-dev COMPONENT library OPTIONAL)
# The package does not enable the units. The administrator decides that.
install(FILES native/packaging/isosplat.service native/packaging/isosplat.socket
        DESTINATION lib/systemd/system COMPONENT program)
install(FILES native/packaging/nginx.conf native/packaging/nginx-cluster.conf native/packaging/Caddyfile native/packaging/Containerfile
              native/packaging/grafana-dashboard.json
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/isosplat/examples COMPONENT program)

set(CPACK_GENERATOR DEB TGZ)
set(CPACK_PACKAGE_NAME isosplat)
set(CPACK_PACKAGE_VERSION ${ISOSPLAT_VERSION})
# Debian sorts 1.0.0~rc before 1.0.0.
string(REPLACE - ~ CPACK_DEBIAN_PACKAGE_VERSION ${ISOSPLAT_VERSION})
set(CPACK_PACKAGE_VENDOR Isosplat)
# .ci/make-packages sets the maintainer.
set(CPACK_PACKAGE_CONTACT "Isosplat <isosplat@localhost>")
set(CPACK_PACKAGE_FILE_NAME isosplat-${ISOSPLAT_VERSION}-linux-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_PACKAGE_CHECKSUM SHA256)
set(CPACK_STRIP_FILES ON)
# Each program comes from a separate build tree, the library from this one.
set(CPACK_INSTALL_CMAKE_PROJECTS "${PROJECT_BINARY_DIR};isosplat;program;/"
                                 "${PROJECT_BINARY_DIR};isosplat;library;/")
foreach(build ${ISOSPLAT_OTHER_BUILDS})
  list(PREPEND CPACK_INSTALL_CMAKE_PROJECTS "${build};isosplat;program;/")
endforeach()
# The components that each line above installs, for generators that create one package per component.
set(CPACK_COMPONENTS_PROGRAM program)
set(CPACK_COMPONENTS_LIBRARY library)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME isosplat)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# The software renderer for machines without a GPU, for `isosplat render`.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS libgl1-mesa-dri)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "isosurfaces of large volumes, as splats in a browser
The program turns volumes (DICOM, NIfTI, NRRD, MetaImage, MRC, MGH, NumPy,
HDF5, TIFF, VTK, raw) into stores, from which it reads any isosurface without
further processing. It serves stores over HTTP, and draws pictures of them.
The page shows them in a browser.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libisosplat-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
# The public headers include tl/expected.hpp.
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS libexpected-dev)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "isosurfaces from Isosplat's stores, for C++ programs
Headers, static libraries and the CMake package isosplat: find the chunks of
an isovalue in a store, decode them, and project their samples.")
if(TARGET isosplat_python)
  include(native/packaging/python.cmake)
endif()
include(CPack)
