# The component python: the Debian package python3-isosplat, and the Python part of the archive, from
# which native/packaging/make-wheel makes the wheel.

# In the form of PEP 440: 1.0.0-rc.1 is 1.0.0rc1.
string(REPLACE -rc. rc python_version ${ISOSPLAT_VERSION})
if(NOT python_version MATCHES "^[0-9]+\\.[0-9]+\\.[0-9]+(rc[0-9]+)?$")
  message(FATAL_ERROR "package.json: expected a version such as 1.2.3 or 1.2.3-rc.1, found "
                      "${ISOSPLAT_VERSION}, which Python has no form for")
endif()
get_target_property(major isosplat_python PYTHON_MAJOR)
get_target_property(minor isosplat_python PYTHON_MINOR)
set(packages lib/python3/dist-packages) # Debian's folder
set(distribution isosplat-${python_version}.dist-info)
configure_file(native/packaging/python-metadata.in ${PROJECT_BINARY_DIR}/${distribution}/METADATA @ONLY)

set(readable OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
install(TARGETS isosplat_python LIBRARY DESTINATION ${packages}/isosplat PERMISSIONS ${readable}
        COMPONENT python)
install(DIRECTORY native/python/package/isosplat DESTINATION ${packages} COMPONENT python
        FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "*.js" PATTERN py.typed)
install(FILES web/npm/python/isosplat_widget.py DESTINATION ${packages}/isosplat RENAME _widget_traits.py
        COMPONENT python)
install(FILES ${PROJECT_BINARY_DIR}/${distribution}/METADATA DESTINATION ${packages}/${distribution}
        COMPONENT python)
install(FILES native/packaging/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-isosplat
        COMPONENT python)
install(FILES ${documents}/changelog.gz ${documents}/CHANGELOG.md.gz
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-isosplat COMPONENT python)

list(APPEND CPACK_INSTALL_CMAKE_PROJECTS "${PROJECT_BINARY_DIR};isosplat;python;/")
set(CPACK_COMPONENTS_PYTHON python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-isosplat)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
# The module is compiled for one minor version of Python, and belongs to this version of the program.
math(EXPR next "${minor} + 1")
string(CONCAT CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
       "isosplat (= ${CPACK_DEBIAN_PACKAGE_VERSION}), "
       "python3 (>= ${major}.${minor}), python3 (<< ${major}.${next}), python3-numpy")
# They compile and remove bytecode, as Debian's policy for Python demands.
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    ${PROJECT_SOURCE_DIR}/native/packaging/postinst ${PROJECT_SOURCE_DIR}/native/packaging/prerm)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "isosurfaces of large volumes, for Python
The package isosplat builds stores from NumPy arrays and from files, and
returns points, triangles, areas and volumes of their isosurfaces as arrays.")
