#pragma once

#include <memory>

#include "shared/base/status.h"

namespace isosplat {

/// An OpenGL ES 3.0 context without window or display server, current on the thread that made it
/// until it is destroyed. Drawing goes to framebuffer objects.
class EglContext {
 public:
  /// Errors: gl_error, with what EGL offers and what to install.
  static Result<std::unique_ptr<EglContext>> create();
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

 private:
  EglContext(void* display, void* context) : display_(display), context_(context) {}
  void* display_;
  void* context_;
};

}  // namespace isosplat
