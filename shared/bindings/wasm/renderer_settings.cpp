#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <vector>

#include "shared/bindings/wasm/renderer_api.h"
#include "shared/bindings/wasm/renderer_state.h"
#include "shared/render/settings/colour_maps.h"

// The functions of renderer_api.h that set how the volumes are drawn.
using namespace isosplat;
using namespace isosplat::render;
using namespace isosplat::render::wasm;

namespace {

std::vector<Plane> planes_of(std::span<const IsosplatPlane> records) {
  std::vector<Plane> planes;
  for (const IsosplatPlane& plane : records) {
    planes.push_back({as_vector(plane.normal), plane.offset});
  }
  return planes;
}

/// Changes some of the renderer's settings.
template <class Change>
void change_settings(Change change) {
  if (!state().renderer) return;
  RenderSettings settings = state().renderer->settings();
  change(settings);
  state().renderer->set_settings(settings);
}

}  // namespace

void isosplat_renderer_set_isosurfaces(uint32_t volume, const IsosplatIsosurface* isosurfaces,
                                       uint32_t count) {
  change_settings([&](RenderSettings& settings) {
    auto& all = settings.isosurfaces;
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const Isosurface& each) { return each.volume == volume; }),
              all.end());
    std::vector<Isosurface> own;
    for (const IsosplatIsosurface& isosurface :
         std::span(isosurfaces, std::min<uint32_t>(count, kMaxIsosurfaces))) {
      const float* colour = isosurface.colour;
      own.push_back(
          {isosurface.isovalue, {colour[0], colour[1], colour[2]}, isosurface.opacity, volume});
    }
    const auto next = std::find_if(all.begin(), all.end(),
                                   [&](const Isosurface& each) { return each.volume > volume; });
    all.insert(next, own.begin(), own.end());
  });
}

void isosplat_renderer_set_splats(uint32_t kind, uint32_t shading) {
  constexpr auto kLastKind = static_cast<uint32_t>(SplatKind::exact);
  constexpr auto kLastShading = static_cast<uint32_t>(Shading::exact);
  change_settings([&](RenderSettings& settings) {
    settings.kind = static_cast<SplatKind>(std::min(kind, kLastKind));
    settings.shading = static_cast<Shading>(std::min(shading, kLastShading));
  });
}

void isosplat_renderer_set_appearance(const IsosplatAppearance* appearance) {
  constexpr auto kLast = static_cast<uint32_t>(ColourBy::field);
  constexpr auto kLastScale = static_cast<uint32_t>(FieldScale::symmetric);
  constexpr uint32_t kMostSteps = 256;
  change_settings([&](RenderSettings& settings) {
    settings.colour_by = static_cast<ColourBy>(std::min(appearance->colour_by, kLast));
    settings.colour_map =
        static_cast<ColourMap>(std::min<uint32_t>(appearance->colour_map, kColourMaps - 1));
    settings.colour_low = appearance->colour_low;
    settings.colour_high = appearance->colour_high;
    std::copy(std::begin(appearance->background), std::end(appearance->background),
              settings.background.begin());
    settings.field_scale = static_cast<FieldScale>(std::min(appearance->field_scale, kLastScale));
    settings.field_steps = static_cast<int>(std::min(appearance->field_steps, kMostSteps));
    settings.field_lines = appearance->field_lines;
    // NaN would differ from itself.
    if (!std::isfinite(settings.field_lines)) settings.field_lines = 0;
    const float* missing = appearance->field_missing;
    settings.field_missing_colour = {missing[0], missing[1], missing[2]};
    settings.eye_dome = appearance->eye_dome;
  });
}

void isosplat_renderer_set_categories(double first, const uint8_t* colours, uint32_t count) {
  change_settings([&](RenderSettings& settings) {
    settings.field_first_category = first;
    settings.field_categories.resize(std::min<size_t>(count, kMaxCategoryColours));
    for (size_t i = 0; i < settings.field_categories.size(); ++i) {
      std::copy_n(colours + 3 * i, 3, settings.field_categories[i].begin());
    }
  });
}

void isosplat_renderer_set_light(const IsosplatLight* light) {
  change_settings([&](RenderSettings& settings) {
    settings.light = {light->azimuth,
                      light->elevation,
                      light->key,
                      light->sky,
                      light->rim,
                      light->highlight,
                      light->roughness,
                      light->occlusion,
                      light->occlusion_radius,
                      light->shadow,
                      light->shadow_softness};
  });
}

const uint8_t* isosplat_renderer_colour_map(uint32_t colour_map) {
  return colour_map < kColourMaps ? &kColourMapTable[colour_map][0][0] : nullptr;
}

void isosplat_renderer_set_clipping(const IsosplatClipBox* box, const IsosplatPlane* planes,
                                    uint32_t count) {
  change_settings([&](RenderSettings& settings) {
    settings.clip_box_low = as_vector(box->low);
    settings.clip_box_high = as_vector(box->high);
    settings.clip_caps = box->caps != 0;
    settings.clip_planes = planes_of(std::span(planes, std::min<uint32_t>(count, kMaxClipPlanes)));
  });
}

void isosplat_renderer_set_slices(uint32_t volume, const IsosplatPlane* planes, uint32_t count,
                                  double low, double high, uint32_t mapped) {
  change_settings([&](RenderSettings& settings) {
    settings.slices_mapped = mapped != 0;
    settings.slice_volume = volume;
    settings.slice_low = low;
    settings.slice_high = high;
    settings.slices = planes_of(std::span(planes, std::min<uint32_t>(count, kMaxSlices)));
  });
}
