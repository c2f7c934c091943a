# cmake -DMODE=package|folder -DSOURCE=… -DWORK=… -DPROGRAM=… -DSTORE=… -DISOVALUE=…
#       -DGENERATOR=… -DCOMPILER=… [-DBUILD=…] [-DPREFIX=…] [-DLAUNCHER=…] -P run.cmake
# Builds tests/install against Isosplat, runs it, and compares its points with those that
# `isosplat extract` writes. MODE package takes the library that is installed in PREFIX, or without
# PREFIX installs that of BUILD.

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
set(options -S ${SOURCE}/tests/install -B ${WORK}/build -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
            -DCMAKE_CXX_COMPILER=${COMPILER})
if(LAUNCHER)
  list(APPEND options -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}
       -DGIVEN_CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
endif()

if(MODE STREQUAL "package")
  if(PREFIX)
    file(COPY ${PREFIX}/ DESTINATION ${WORK}/first)
  else()
    run(${CMAKE_COMMAND} --install ${BUILD} --component library --prefix ${WORK}/first)
  endif()
  # Wherever it is moved to, it works.
  file(RENAME ${WORK}/first ${WORK}/moved)
  list(APPEND options -DCMAKE_PREFIX_PATH=${WORK}/moved)
  file(GLOB_RECURSE headers RELATIVE ${WORK}/moved/include ${WORK}/moved/include/*)
  foreach(header ${headers})
    if(NOT header MATCHES "^isosplat/[a-z_]+\\.h$")
      message(FATAL_ERROR "only the public headers are installed, found ${header}")
    endif()
    file(READ ${WORK}/moved/include/${header} text)
    if(text MATCHES "#include \"(shared|native|server)/")
      message(FATAL_ERROR "${header} includes a header that is not installed")
    endif()
  endforeach()
  if(NOT EXISTS ${WORK}/moved/share/doc/libisosplat-dev/README.md)
    message(FATAL_ERROR "the package has no README")
  endif()
  list(APPEND options -Dexamples=${WORK}/moved/share/doc/libisosplat-dev/examples)
  file(GLOB_RECURSE scripts ${WORK}/moved/*.cmake)
  foreach(script ${scripts})
    file(READ ${script} text)
    foreach(place ${SOURCE} ${WORK}/first)
      string(FIND "${text}" "${place}" found)
      if(NOT found EQUAL -1)
        message(FATAL_ERROR "${script} names ${place}: the package cannot be moved")
      endif()
    endforeach()
  endforeach()
else()
  list(APPEND options -DISOSPLAT_SOURCE=${SOURCE})
endif()

run(${CMAKE_COMMAND} ${options})
run(${CMAKE_COMMAND} --build ${WORK}/build --target points plugin)

execute_process(COMMAND ${WORK}/build/points ${STORE} ${ISOVALUE}
                OUTPUT_FILE ${WORK}/points.txt RESULT_VARIABLE status TIMEOUT 60)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "points: ${status}")
endif()
file(STRINGS ${WORK}/points.txt points)
list(LENGTH points found)
run(${PROGRAM} extract ${STORE} --isovalue ${ISOVALUE} --output ${WORK}/points.ply)
file(STRINGS ${WORK}/points.ply header REGEX "^element vertex ")
string(REGEX MATCH "[0-9]+" expected "${header}")
if(NOT found EQUAL expected OR found EQUAL 0)
  message(FATAL_ERROR "expected ${expected} points as `isosplat extract` writes, found ${found}")
endif()
message(STATUS "${found} points")

execute_process(COMMAND ${WORK}/build/points ${SOURCE}/README.md ${ISOVALUE}
                ERROR_VARIABLE message RESULT_VARIABLE status TIMEOUT 60)
if(NOT status EQUAL 1 OR NOT message MATCHES "README.md")
  message(FATAL_ERROR "expected an error that names the file, found ${status}: ${message}")
endif()
