#include "shared/bindings/wasm/renderer_state.h"

namespace isosplat::render::wasm {

State& state() {
  static State instance;
  return instance;
}

IsosplatStatus report(const Error& error) {
  state().error = error.message;
  return static_cast<IsosplatStatus>(error.status);
}

IsosplatStatus no_renderer() {
  return report({Status::invalid_argument,
                 "no renderer has been created on a canvas yet: call isosplat_renderer_create"});
}

Renderer* current() {
  State& s = state();
  if (s.renderer) emscripten_webgl_make_context_current(s.context);
  return s.renderer.get();
}

}  // namespace isosplat::render::wasm
