#include "shared/render/gl/gl_program.h"

#include <utility>

#include "shared/render/shaders/shader_files.h"

namespace isosplat::render {
namespace {

void attach(GLuint program, GLenum stage, const std::string& text) {
  const GLuint shader = glCreateShader(stage);
  const char* pointer = text.c_str();
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  glAttachShader(program, shader);
  glDeleteShader(shader);  // the program keeps it
}

/// The driver's log of a shader that does not compile, or else of linking.
std::string log_of(GLuint program) {
  std::string log(4096, '\0');
  GLsizei length = 0;
  GLuint shaders[2] = {0, 0};
  GLsizei count = 0;
  glGetAttachedShaders(program, 2, &count, shaders);
  for (GLsizei i = 0; i < count; ++i) {
    GLint done = 0;
    glGetShaderiv(shaders[i], GL_COMPILE_STATUS, &done);
    if (done) continue;
    glGetShaderInfoLog(shaders[i], static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<size_t>(length));
    return "a shader does not compile with this driver: " + log;
  }
  glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<size_t>(length));
  return "shaders do not link with this driver: " + log;
}

}  // namespace

std::string shader_text(std::string_view defines, std::initializer_list<std::string_view> files) {
  std::string text =
      "#version 300 es\n"
      "precision highp float;\nprecision highp int;\nprecision highp sampler2D;\n";
  text += defines;
  text += shader_file("shader_constants.h");
  text += shader_file("skippable_if.glsl");
  for (const std::string_view file : files) {
    if (file.empty()) continue;
    const std::string_view part = shader_file(file);
    // The log of the driver then names the file that is missing.
    text += part.empty() ? "#error no shader file " + std::string(file) + "\n" : std::string(part);
  }
  return text;
}

GlProgram& GlProgram::operator=(GlProgram&& other) noexcept {
  std::swap(name_, other.name_);
  return *this;
}

GlProgram::~GlProgram() {
  if (name_) glDeleteProgram(name_);
}

GlProgram GlProgram::start(std::string_view defines,
                           std::initializer_list<std::string_view> vertex_files,
                           std::initializer_list<std::string_view> fragment_files) {
  return start(shader_text(defines, vertex_files), shader_text(defines, fragment_files));
}

GlProgram GlProgram::start(const std::string& vertex_text, const std::string& fragment_text) {
  GlProgram program;
  program.name_ = glCreateProgram();
  attach(program.name_, GL_VERTEX_SHADER, vertex_text);
  attach(program.name_, GL_FRAGMENT_SHADER, fragment_text);
  glLinkProgram(program.name_);
  return program;
}

bool GlProgram::is_done() const {
  constexpr GLenum kCompletionStatus = 0x91B1;  // COMPLETION_STATUS_KHR
  GLint done = 0;
  glGetProgramiv(name_, kCompletionStatus, &done);
  return done != 0;
}

Result<void> GlProgram::finish() {
  GLint done = 0;
  glGetProgramiv(name_, GL_LINK_STATUS, &done);
  if (!done) return fail(Status::gl_error, log_of(name_));
  return {};
}

Result<GlProgram> GlProgram::link(std::string_view defines,
                                  std::initializer_list<std::string_view> vertex_files,
                                  std::initializer_list<std::string_view> fragment_files) {
  GlProgram program = start(defines, vertex_files, fragment_files);
  if (auto ok = program.finish(); !ok) return tl::unexpected(ok.error());
  return program;
}

}  // namespace isosplat::render
