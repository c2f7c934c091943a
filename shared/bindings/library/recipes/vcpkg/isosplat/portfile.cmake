# An overlay port for the clone that contains it:
#   vcpkg install isosplat --overlay-ports=CLONE/shared/bindings/library/recipes/vcpkg
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../../../../../.." REALPATH)

vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS -DISOSPLAT_PROGRAM=OFF -DISOSPLAT_TESTS=OFF -DISOSPLAT_WARNINGS=OFF -DISOSPLAT_CCACHE=OFF
          -DISOSPLAT_ARCH=)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME isosplat CONFIG_PATH lib/cmake/isosplat)
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
