#include <algorithm>

#include "shared/bindings/wasm/renderer_api.h"
#include "shared/bindings/wasm/renderer_state.h"

// The functions of renderer_api.h that set, change and project a camera.
using namespace isosplat;
using namespace isosplat::render;
using namespace isosplat::render::wasm;

namespace {

Camera read_camera(const IsosplatCamera& record) {
  Camera camera;
  camera.target = as_vector(record.target);
  camera.distance = record.distance;
  camera.azimuth = record.azimuth;
  camera.elevation = record.elevation;
  camera.roll = record.roll;
  camera.field_of_view = record.field_of_view;
  camera.orthographic = record.orthographic != 0;
  return camera;
}

IsosplatCamera record_of(const Camera& camera) {
  return {{camera.target.x, camera.target.y, camera.target.z},
          camera.distance,
          camera.azimuth,
          camera.elevation,
          camera.roll,
          camera.field_of_view,
          camera.orthographic ? 1.0 : 0.0};
}

/// Around the renderer's volumes.
VolumeGrid grid() {
  return state().renderer ? state().renderer->scene_grid() : VolumeGrid{{2, 2, 2}};
}

}  // namespace

void isosplat_renderer_set_camera(const IsosplatCamera* camera) {
  if (state().renderer) state().renderer->set_camera(read_camera(*camera));
}

void isosplat_renderer_default_camera(IsosplatCamera* camera, double aspect) {
  *camera = record_of(default_camera(grid(), aspect, camera->orthographic != 0));
}

void isosplat_renderer_orbit(IsosplatCamera* camera, double right_degrees, double up_degrees) {
  *camera = record_of(orbited(read_camera(*camera), right_degrees, up_degrees));
}

void isosplat_renderer_pan(IsosplatCamera* camera, double right_px, double down_px,
                           double image_height_px) {
  *camera = record_of(panned(read_camera(*camera), right_px, down_px, image_height_px));
}

void isosplat_renderer_zoom(IsosplatCamera* camera, double factor) {
  *camera = record_of(zoomed(read_camera(*camera), factor, bounding_sphere(grid()).radius));
}

void isosplat_renderer_bound(IsosplatCamera* camera) {
  *camera = record_of(bounded(read_camera(*camera), grid()));
}

void isosplat_renderer_projection(const IsosplatCamera* camera, int32_t width, int32_t height,
                                  IsosplatProjection* result) {
  const Projection projected = projection(read_camera(*camera), bounding_sphere(grid()), {0, 0, 0},
                                          std::max(width, 1), std::max(height, 1));
  std::copy(projected.clip_from_world.begin(), projected.clip_from_world.end(),
            result->clip_from_world);
}
