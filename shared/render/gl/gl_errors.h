#pragma once

#include <GLES3/gl3.h>

namespace isosplat::render {

/// The errors of a GL context since the last take(). Code that calls glGetError() itself must call
/// collect() first. Otherwise it would remove errors that other code must report.
/// Reading an error waits until the GPU has finished all pending work.
class GlErrors {
 public:
  struct Found {
    bool out_of_memory = false;
    GLenum other = GL_NO_ERROR;  ///< the first one
  };

  const Found& collect() {
    constexpr GLenum kContextLost = 0x9242;  // WebGL repeats it as long as it holds
    for (GLenum error = glGetError(); error != GL_NO_ERROR; error = glGetError()) {
      if (error == kContextLost) break;
      if (error == GL_OUT_OF_MEMORY) {
        found_.out_of_memory = true;
      } else if (found_.other == GL_NO_ERROR) {
        found_.other = error;
      }
    }
    return found_;
  }

  /// Collects the errors, returns them, and clears them.
  Found take() {
    const Found found = collect();
    found_ = {};
    return found;
  }

 private:
  Found found_;
};

}  // namespace isosplat::render
