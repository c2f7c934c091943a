#pragma once

#include <emscripten/html5.h>

#include <memory>
#include <string>
#include <vector>

#include "shared/bindings/wasm/renderer_api.h"
#include "shared/render/renderer.h"

// Shared by the functions of renderer_api.h: the state of the module, and its errors.
namespace isosplat::render::wasm {

/// The state of the module: JavaScript creates one instance of the module per canvas. The renderer
/// holds the volumes, the settings and the camera.
struct State {
  EMSCRIPTEN_WEBGL_CONTEXT_HANDLE context = 0;
  std::unique_ptr<Renderer> renderer;
  std::string error;
  std::vector<IsosplatVisibility> occlusion_answer;  ///< of the last query
};

/// The only instance.
State& state();

inline constexpr IsosplatStatus kOk = static_cast<IsosplatStatus>(Status::ok);

/// Sets the message of the last error, and returns its status.
IsosplatStatus report(const Error& error);

template <class T>
IsosplatStatus status_of(const Result<T>& result) {
  return result ? kOk : report(result.error());
}

/// The error of a function that needs a renderer.
IsosplatStatus no_renderer();

/// The renderer with its context current; null before isosplat_renderer_create.
Renderer* current();

inline Vec3d as_vector(const double* numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

}  // namespace isosplat::render::wasm
