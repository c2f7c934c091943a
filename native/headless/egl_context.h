#pragma once

#include <memory>

#include "shared/core/base/status.h"

namespace isosplat {

/// An OpenGL ES 3.0 context without window or display server. It is current on the thread that
/// created it, until it is destroyed. Draw to framebuffer objects.
class EglContext {
 public:
  /// Errors: gl_error, with the packages to install.
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
