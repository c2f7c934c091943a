# cmake -DOUTPUT=… -DFOLDER=… -P embed_shaders.cmake: writes all shader files, and the constants that they
# share with C++, to one C++ source. Removes comments and indentation, because each visitor of the page
# downloads this text. Lines keep their numbers.
file(GLOB files ${FOLDER}/*.glsl)
set(text "#include \"shared/render/shaders/shader_files.h\"\n\nnamespace isosplat::render {\n\nstd::string_view shader_file(std::string_view name) {\n")
foreach(file ${files} ${FOLDER}/shader_constants.h)
  get_filename_component(name ${file} NAME)
  file(READ ${file} content)
  string(REGEX REPLACE "[ ]*//[^\n]*" "" content "${content}")
  string(REGEX REPLACE "\n[ ]+" "\n" content "${content}")
  string(APPEND text "  if (name == \"${name}\") return R\"GLSL(${content})GLSL\";\n")
endforeach()
string(APPEND text "  return {};\n}\n\n}  // namespace isosplat::render\n")
file(WRITE ${OUTPUT} "${text}")
