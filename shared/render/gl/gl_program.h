#pragma once

#include <GLES3/gl3.h>

#include <initializer_list>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"

namespace isosplat::render {

/// A GL program. Movable. Owns the GL object until abandon().
class GlProgram {
 public:
  GlProgram() = default;
  GlProgram(GlProgram&& other) noexcept : name_(other.name_) { other.name_ = 0; }
  GlProgram& operator=(GlProgram&& other) noexcept;
  ~GlProgram();

  /// Starts to compile and link, and does not wait for the driver: call finish() before the program
  /// is used. Each shader is the concatenation of the named files (shared/render/shaders) after
  /// `defines` (whole lines), shader_constants.h and skippable_if.glsl. Empty names are left out.
  static GlProgram start(std::string_view defines,
                         std::initializer_list<std::string_view> vertex_files,
                         std::initializer_list<std::string_view> fragment_files);

  /// As above, from whole shaders.
  static GlProgram start(const std::string& vertex_text, const std::string& fragment_text);

  /// Whether finish() would return at once. Requires KHR_parallel_shader_compile.
  bool is_done() const;

  /// Waits until the driver has linked it. Errors: gl_error, with the driver's log.
  Result<void> finish();

  /// start() and finish().
  static Result<GlProgram> link(std::string_view defines,
                                std::initializer_list<std::string_view> vertex_files,
                                std::initializer_list<std::string_view> fragment_files);

  GLuint name() const { return name_; }
  GLint uniform(const char* name) const { return glGetUniformLocation(name_, name); }
  explicit operator bool() const { return name_ != 0; }

  /// The context that owned the program is gone: the destructor deletes nothing.
  void abandon() { name_ = 0; }

 private:
  GLuint name_ = 0;
};

/// The source text of a shader: version, precision, defines, constants, files.
std::string shader_text(std::string_view defines, std::initializer_list<std::string_view> files);

}  // namespace isosplat::render
