# `cmake --build BUILD --target docs`: the reference of the public headers. Warnings are errors.
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
  set(DOXYGEN_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/docs)
  set(DOXYGEN_STRIP_FROM_PATH ${PROJECT_SOURCE_DIR}/shared/core/include)
  set(DOXYGEN_USE_MDFILE_AS_MAINPAGE ${PROJECT_SOURCE_DIR}/shared/bindings/library/README.md)
  set(DOXYGEN_EXTRACT_ALL NO)
  set(DOXYGEN_HIDE_UNDOC_RELATIONS YES)
  set(DOXYGEN_MACRO_EXPANSION YES)
  set(DOXYGEN_GENERATE_LATEX NO)
  set(DOXYGEN_WARN_AS_ERROR FAIL_ON_WARNINGS)
  set(DOXYGEN_QUIET YES)
  doxygen_add_docs(docs ${PROJECT_SOURCE_DIR}/shared/core/include/isosplat
                   ${PROJECT_BINARY_DIR}/include/isosplat)
else()
  add_custom_target(docs COMMAND ${CMAKE_COMMAND} -E echo "docs needs Doxygen: apt-get install doxygen"
                         COMMAND ${CMAKE_COMMAND} -E false)
endif()
