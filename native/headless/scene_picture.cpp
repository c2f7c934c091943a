#include "native/headless/scene_picture.h"

#include "native/headless/show_categories.h"

#include <fmt/format.h>

#include <algorithm>

#include "native/headless/store_scene.h"
#include "native/scene/layer_surfaces.h"
#include "shared/system/store_file/field_file.h"

namespace isosplat {
namespace {

/// The smallest box along the axes of the world around several grids.
class WorldBox {
 public:
  void add(const VolumeGrid& grid) {
    for (int i = 0; i < 8; ++i) {
      const Vec3d corner =
          grid.world({i & 1 ? grid.voxels.x - 1.0 : 0.0, i & 2 ? grid.voxels.y - 1.0 : 0.0,
                      i & 4 ? grid.voxels.z - 1.0 : 0.0});
      low_ = {std::min(low_.x, corner.x), std::min(low_.y, corner.y), std::min(low_.z, corner.z)};
      high_ = {std::max(high_.x, corner.x), std::max(high_.y, corner.y),
               std::max(high_.z, corner.z)};
    }
  }
  VolumeGrid grid() const { return {{2, 2, 2}, high_ - low_, low_}; }

 private:
  Vec3d low_{1e300, 1e300, 1e300}, high_{-1e300, -1e300, -1e300};
};

/// Null if the store has no field of this name.
Result<std::shared_ptr<StoreFile>> field_of(const StoreFile& store, const std::string& name) {
  const auto& fields = store.info().fields;
  const auto found =
      std::ranges::find(fields, name, [](const auto& each) { return each.info.name; });
  if (name.empty() || found == fields.end()) return nullptr;
  return open_field(store, static_cast<size_t>(found - fields.begin()));
}

void add_names(const StoreInfo& store, std::vector<std::string>& names) {
  for (const FieldRef& field : store.fields) {
    if (std::ranges::find(names, field.info.name) == names.end()) names.push_back(field.info.name);
  }
}

}  // namespace

Result<ScenePicture> show_scene(render::Renderer& renderer, const SceneFile& file, size_t step,
                                std::optional<uint32_t> level, uint64_t sample_budget,
                                const std::string& field) {
  const Scene& scene = file.scene();
  if (auto exists = check_step(scene, step); !exists) return tl::unexpected(exists.error());
  ScenePicture picture;
  WorldBox box;
  std::optional<SceneFieldRange> all_values;  // of the field
  auto left =
      static_cast<uint64_t>(std::count_if(scene.layers.begin(), scene.layers.end(),
                                          [](const SceneLayer& layer) { return layer.visible; }));
  for (size_t i = 0; i < scene.layers.size(); ++i) {
    const SceneLayer& layer = scene.layers[i];
    if (!layer.visible) continue;
    const auto opened = open_layer(file, i, step);
    if (!opened) return tl::unexpected(opened.error());
    const StoreFile& store = *opened->store;
    VolumePlace place{static_cast<render::VolumeId>(i), opened->grid};
    const auto values = field_of(store, field);
    if (!values) return tl::unexpected(with_layer(scene, i, values.error()));
    place.field = values->get();
    add_names(store.info(), picture.fields);
    const std::vector<SceneSurface> surfaces = surfaces_of(layer, store.info(), picture.layers);
    if (surfaces.empty()) picture.notes.push_back(no_surfaces(scene, i));
    std::vector<double> isovalues;
    for (const SceneSurface& surface : surfaces) {
      isovalues.push_back(surface.isovalue);
      const auto [red, green, blue] = *surface.colour;
      picture.isosurfaces.push_back(
          {surface.isovalue, {red, green, blue}, surface.opacity, place.volume});
    }
    const uint64_t budget = (sample_budget - std::min(picture.samples, sample_budget)) / left--;
    const auto shown = show_store(renderer, store, isovalues, level, budget, 0, place);
    if (!shown) return tl::unexpected(with_layer(scene, i, shown.error()));
    if (!picture.field_range) picture.field_range = shown->field_range;
    if (place.field)
      add_categories(categories_of(place.field->info().metadata), picture.categories);
    if (place.field && !all_values) {
      const FieldInfo& info = *place.field->info().field;
      all_values = {info.mapping.value(info.range.min), info.mapping.value(info.range.max)};
    }
    picture.samples += shown->samples;
    picture.coarsest = std::max(picture.coarsest, shown->level);
    ++picture.layers;
    box.add(opened->grid);
    if (i == 0) {
      const StoreInfo& info = store.info();
      const GreyRange all{info.mapping.value(info.range.min), info.mapping.value(info.range.max)};
      picture.first = FirstVolume{opened->grid, all.low, all.high, grey_range(info.metadata, all)};
    }
  }
  if (picture.layers == 0) {
    return fail(Status::not_found,
                "expected a visible layer, found none: set visible to true for at least one layer");
  }
  if (!picture.field_range) picture.field_range = all_values;
  if (!field.empty() && !picture.field_range) {
    picture.notes.push_back(fmt::format("no visible layer has values of the field '{}'", field));
  }
  picture.extent = box.grid();
  return picture;
}

}  // namespace isosplat
