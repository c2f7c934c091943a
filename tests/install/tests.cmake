# The library as others take it: installed, and as a folder of their project.
foreach(mode package folder)
  add_test(NAME install_${mode} COMMAND ${CMAKE_COMMAND}
    -DMODE=${mode} -DBUILD=${PROJECT_BINARY_DIR} -DSOURCE=${PROJECT_SOURCE_DIR}
    -DWORK=${PROJECT_BINARY_DIR}/tests/install/${mode} -DPROGRAM=$<TARGET_FILE:isosplat>
    -DSTORE=${PROJECT_SOURCE_DIR}/tests/golden/v1.0/u8.isosplat -DISOVALUE=100
    -DCOMPILER=${CMAKE_CXX_COMPILER} -DLAUNCHER=${ISOSPLAT_CCACHE_PROGRAM}
    -DGENERATOR=${CMAKE_GENERATOR} -P ${PROJECT_SOURCE_DIR}/tests/install/run.cmake)
  set_tests_properties(install_${mode} PROPERTIES LABELS install TIMEOUT 900)
endforeach()
# It compiles the whole library again.
set_tests_properties(install_folder PROPERTIES LABELS "install;release")
add_test(NAME install_recipes COMMAND ${CMAKE_COMMAND}
  -DSOURCE=${PROJECT_SOURCE_DIR} -DWORK=${PROJECT_BINARY_DIR}/tests/install/recipes
  -DCOMPILER=${CMAKE_CXX_COMPILER} -DLAUNCHER=${ISOSPLAT_CCACHE_PROGRAM}
  -DGENERATOR=${CMAKE_GENERATOR} -P ${PROJECT_SOURCE_DIR}/tests/install/recipes.cmake)
set_tests_properties(install_recipes PROPERTIES LABELS "install;release" TIMEOUT 900)
