#include "shared/render/gl_program.h"

#include <utility>

#include "shared/render/shader_files.h"

namespace isosplat {
namespace {

Result<GLuint> compile(GLenum stage, const std::string& text) {
  const GLuint shader = glCreateShader(stage);
  const char* pointer = text.c_str();
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  GLint done = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<size_t>(length));
  glDeleteShader(shader);
  return fail(Status::gl_error, "a shader does not compile with this driver: " + log);
}

}  // namespace

std::string shader_text(std::string_view defines, std::initializer_list<std::string_view> files) {
  std::string text =
      "#version 300 es\n"
      "precision highp float;\nprecision highp int;\nprecision highp sampler2D;\n";
  text += defines;
  text += shader_file("shader_constants.h");
  for (const std::string_view file : files) text += shader_file(file);
  return text;
}

GlProgram& GlProgram::operator=(GlProgram&& other) noexcept {
  std::swap(name_, other.name_);
  return *this;
}

GlProgram::~GlProgram() {
  if (name_) glDeleteProgram(name_);
}

Result<GlProgram> GlProgram::link(std::string_view defines,
                                  std::initializer_list<std::string_view> vertex_files,
                                  std::initializer_list<std::string_view> fragment_files) {
  const auto vertex = compile(GL_VERTEX_SHADER, shader_text(defines, vertex_files));
  if (!vertex) return tl::unexpected(vertex.error());
  const auto fragment = compile(GL_FRAGMENT_SHADER, shader_text(defines, fragment_files));
  if (!fragment) {
    glDeleteShader(*vertex);
    return tl::unexpected(fragment.error());
  }
  GlProgram program;
  program.name_ = glCreateProgram();
  glAttachShader(program.name_, *vertex);
  glAttachShader(program.name_, *fragment);
  glLinkProgram(program.name_);
  glDeleteShader(*vertex);
  glDeleteShader(*fragment);
  GLint done = 0;
  glGetProgramiv(program.name_, GL_LINK_STATUS, &done);
  if (done) return program;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(program.name_, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<size_t>(length));
  return fail(Status::gl_error, "shaders do not link with this driver: " + log);
}

}  // namespace isosplat
