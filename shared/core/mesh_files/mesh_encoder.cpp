#include "shared/core/mesh_files/mesh_encoder.h"

#include <algorithm>

#include "shared/core/mesh_files/glb_encoder.h"
#include "shared/core/mesh_files/ply_encoder.h"
#include "shared/core/mesh_files/stl_encoder.h"

namespace isosplat {

std::vector<std::string> column_names(std::span<const FieldColumn> fields,
                                      std::span<const std::string_view> used) {
  std::vector<std::string> names;
  for (size_t i = 0; i < fields.size(); ++i) {
    std::string name = fields[i].name;
    const auto is_used = [&] {
      return std::find(used.begin(), used.end(), name) != used.end() ||
             std::find(names.begin(), names.end(), name) != names.end() ||
             (name != fields[i].name &&
              std::any_of(fields.begin(), fields.end(),
                          [&](const FieldColumn& other) { return other.name == name; }));
    };
    while (is_used()) name += "_field";
    names.push_back(std::move(name));
  }
  return names;
}

std::string description_of(const FieldColumn& field) {
  std::string text = field.name;
  if (!field.title.empty()) text += ": " + field.title;
  if (!field.units.empty()) text += ", in " + field.units;
  return text;
}

std::unique_ptr<MeshEncoder> make_mesh_encoder(MeshFormatId format, const VolumeGrid& grid,
                                               std::string_view comment) {
  switch (format) {
    case MeshFormatId::stl:
      return std::make_unique<StlEncoder>(comment);
    case MeshFormatId::ply:
      return std::make_unique<PlyEncoder>(grid, comment, PlyEncoder::Content::triangles);
    case MeshFormatId::glb:
      return std::make_unique<GlbEncoder>(grid, comment);
  }
  return nullptr;
}

}  // namespace isosplat
