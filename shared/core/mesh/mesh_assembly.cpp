#include "shared/core/mesh/mesh_assembly.h"

#include <cmath>
#include <limits>
#include <utility>

namespace isosplat {

MeshAssembly::MeshAssembly(const VolumeGrid& grid, uint32_t level)
    : grid_(grid),
      dual_edges_(grid.dual_edges()),
      cell_size_(std::ldexp(1.0, static_cast<int>(level))),
      is_mirrored_(determinant(grid.direction) < 0) {}

Result<void> MeshAssembly::add_layer(std::vector<MeshedBlock> blocks) {
  Layer layer;
  layer.blocks.reserve(blocks.size());
  for (MeshedBlock& block : blocks) {
    layer.blocks.push_back({.block = std::move(block), .border = {}});
    number(layer.blocks.back(), layer);
    if (counts_.vertices > std::numeric_limits<uint32_t>::max()) {
      return fail(Status::out_of_memory,
                  "expected an isosurface of less than 2^32 vertices, found more: choose a coarser "
                  "level");
    }
  }
  complete_ = std::exchange(open_, std::move(layer));
  return {};
}

/// Numbers the vertices of a block, and adds its gradients to those of the vertices that it shares
/// with earlier blocks. The layer below is open_.
void MeshAssembly::number(NumberedBlock& numbered, Layer& layer) {
  const BlockMesh& mesh = numbered.block.mesh;
  numbered.first_number = static_cast<uint32_t>(counts_.vertices);
  numbered.border.reserve(mesh.border.size());
  uint32_t known = 0;
  for (const BorderVertex& border : mesh.border) {
    const Vec3f gradient = mesh.vertices[border.vertex].gradient();
    const auto new_number = static_cast<uint32_t>(counts_.vertices + border.vertex - known);
    const uint64_t key = border.edge.key();
    if (border.edge.axis != 2 && border.edge.low.z == numbered.block.origin.z) {
      if (const uint32_t* below = open_.found.find(key)) {
        // The vertex is written with the layer below; this layer only refers to its number.
        SharedVertex& vertex = open_.shared[*below];
        vertex.gradient = vertex.gradient + gradient;
        numbered.border.push_back(
            {border.vertex, static_cast<uint32_t>(layer.shared.size()), false});
        layer.shared.push_back({vertex.number, {}});
        ++known;
        continue;
      }
    }
    const auto [index, is_new] =
        layer.found.emplace(key, static_cast<uint32_t>(layer.shared.size()));
    if (is_new) layer.shared.push_back({new_number, {}});
    SharedVertex& vertex = layer.shared[index];
    vertex.gradient = vertex.gradient + gradient;
    numbered.border.push_back({border.vertex, index, is_new});
    if (!is_new) ++known;
  }
  counts_.vertices += mesh.vertices.size() - known;
  counts_.triangles += mesh.triangles.size();
}

MeshPart MeshAssembly::take_part(size_t i) {
  NumberedBlock& numbered = complete_.blocks[i];
  auto& [low, mesh] = numbered.block;
  MeshPart part;
  part.vertices.positions.reserve(mesh.vertices.size());
  part.vertices.normals.reserve(mesh.vertices.size());
  part.vertices.fields.resize(mesh.fields.size());
  std::vector<uint32_t> numbers(mesh.vertices.size());
  uint32_t next_number = numbered.first_number;
  auto border = numbered.border.begin();
  for (uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const MeshVertex& vertex = mesh.vertices[v];
    Vec3f g = vertex.gradient();
    if (border != numbered.border.end() && border->vertex == v) {
      const SharedVertex& shared = complete_.shared[border->shared];
      const bool is_new = (border++)->is_new;
      if (!is_new) {
        numbers[v] = shared.number;
        continue;
      }
      g = shared.gradient;
    }
    numbers[v] = next_number++;
    for (size_t field = 0; field < mesh.fields.size(); ++field) {
      part.vertices.fields[field].push_back(mesh.fields[field][v]);
    }
    const Vec3f at = vertex.position;
    part.vertices.positions.push_back(
        grid_.world({cell_size_ * (low.x + double{at.x}), cell_size_ * (low.y + double{at.y}),
                     cell_size_ * (low.z + double{at.z})}));
    const Vec3d gradient = multiply(dual_edges_, Vec3d{g.x, g.y, g.z});
    const double steepness = length(gradient);
    const double factor = steepness > 0 ? -1 / steepness : 0;
    part.vertices.normals.push_back({static_cast<float>(gradient.x * factor),
                                     static_cast<float>(gradient.y * factor),
                                     static_cast<float>(gradient.z * factor)});
  }
  part.triangles = std::move(mesh.triangles);
  for (auto& triangle : part.triangles) {
    for (uint32_t& vertex : triangle) vertex = numbers[vertex];
    if (is_mirrored_) std::swap(triangle[1], triangle[2]);
  }
  return part;
}

}  // namespace isosplat
