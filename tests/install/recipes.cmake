# cmake -DSOURCE=… -DWORK=… -DGENERATOR=… -DCOMPILER=… -P recipes.cmake
# Runs the port for vcpkg with stand-ins that do what the manual says of vcpkg's functions, and builds
# the example with the result. Checks where the recipe for Conan looks for its clone.

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output
                  ERROR_VARIABLE output TIMEOUT 600)
  if(NOT status EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}: ${status}\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
set(recipes ${SOURCE}/shared/bindings/library/recipes)
file(READ ${SOURCE}/package.json package)
string(JSON version GET "${package}" version)

file(READ ${recipes}/vcpkg/isosplat/vcpkg.json manifest)
string(JSON found GET "${manifest}" version-semver)
if(NOT found STREQUAL version)
  message(FATAL_ERROR "vcpkg.json: expected version ${version}, as in package.json, found ${found}")
endif()

function(vcpkg_cmake_configure)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "SOURCE_PATH" "OPTIONS")
  run(${CMAKE_COMMAND} -S ${arg_SOURCE_PATH} -B ${WORK}/build -G ${GENERATOR}
      -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_INSTALL_LIBDIR=lib
      -DCMAKE_INSTALL_PREFIX=${CURRENT_PACKAGES_DIR} ${arg_OPTIONS} ${LAUNCHER})
endfunction()
function(vcpkg_cmake_install)
  run(${CMAKE_COMMAND} --build ${WORK}/build)
  run(${CMAKE_COMMAND} --install ${WORK}/build)
endfunction()
function(vcpkg_cmake_config_fixup)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "PACKAGE_NAME;CONFIG_PATH" "")
  file(MAKE_DIRECTORY ${CURRENT_PACKAGES_DIR}/share)
  file(RENAME ${CURRENT_PACKAGES_DIR}/${arg_CONFIG_PATH}
       ${CURRENT_PACKAGES_DIR}/share/${arg_PACKAGE_NAME})
  # vcpkg rewrites where the package's root is; here the files are one folder less deep.
  foreach(file targets config)
    set(path ${CURRENT_PACKAGES_DIR}/share/isosplat/isosplat-${file}.cmake)
    file(READ ${path} text)
    string(REPLACE "get_filename_component(_IMPORT_PREFIX \"\${_IMPORT_PREFIX}\" PATH)\nif("
                   "if(" text "${text}")
    string(REPLACE "/../../../\" ABSOLUTE" "/../../\" ABSOLUTE" text "${text}")
    file(WRITE ${path} "${text}")
  endforeach()
endfunction()
function(vcpkg_install_copyright)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "FILE_LIST")
  file(INSTALL ${arg_FILE_LIST} DESTINATION ${CURRENT_PACKAGES_DIR}/share/isosplat RENAME copyright)
endfunction()

if(LAUNCHER)
  set(LAUNCHER -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
endif()
set(CURRENT_PORT_DIR ${recipes}/vcpkg/isosplat)
set(CURRENT_PACKAGES_DIR ${WORK}/packages)
include(${CURRENT_PORT_DIR}/portfile.cmake)
run(${CMAKE_COMMAND} -S ${SOURCE}/docs/examples/points -B ${WORK}/example -G ${GENERATOR}
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_PREFIX_PATH=${CURRENT_PACKAGES_DIR})
run(${CMAKE_COMMAND} --build ${WORK}/example)

# Conan is not in Debian: only that the recipe is Python, and finds the clone that contains it.
run(/usr/bin/python3 ${CMAKE_CURRENT_LIST_DIR}/check_conan_recipe.py ${recipes}/conan/conanfile.py)
