#include "shared/bindings/wasm/mesh_api.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/mesh/block_mesh.h"
#include "shared/core/mesh/cell_region.h"
#include "shared/core/mesh/mesh_assembly.h"
#include "shared/core/mesh/solid_region.h"
#include "shared/core/mesh/surface_extent.h"
#include "shared/core/mesh_files/mesh_encoder.h"
#define XXH_INLINE_ALL
#include "xxhash.h"

using namespace isosplat;

namespace {

/// A closed surface, which is complete only at the end.
struct Solid {
  /// Vertices or triangles of a part.
  static constexpr size_t kSlice = 1 << 16;

  SolidRegion region;
  MeshPart mesh = {};
  bool is_complete = false;

  static size_t slices(size_t count) { return (count + kSlice - 1) / kSlice; }
  size_t parts() const {
    return is_complete ? slices(mesh.vertices.positions.size()) + slices(mesh.triangles.size()) : 0;
  }

  /// First the vertices, then the triangles.
  MeshPart part(size_t i) const {
    MeshPart part;
    const size_t of_vertices = slices(mesh.vertices.positions.size());
    const auto copy = [](const auto& from, size_t slice, auto& to) {
      const auto begin = from.begin() + static_cast<std::ptrdiff_t>(slice * kSlice);
      to.assign(begin, begin + std::min<std::ptrdiff_t>(kSlice, from.end() - begin));
    };
    if (i < of_vertices) {
      copy(mesh.vertices.positions, i, part.vertices.positions);
      copy(mesh.vertices.normals, i, part.vertices.normals);
    } else {
      copy(mesh.triangles, i - of_vertices, part.triangles);
    }
    return part;
  }
};

/// A mesh that becomes a file.
struct MeshToFile {
  MeshAssembly assembly;
  std::unique_ptr<MeshEncoder> encoder;
  std::optional<CellRegion> region;
  std::optional<Solid> solid;
  std::vector<MeshedBlock> layer;  ///< the blocks of one z so far
  size_t encoded_parts = 0;        ///< of the completed layer, or of the solid
  int layers_to_complete = 0;      ///< 2 at the end: the last layer, and the one before

  size_t parts_left() const {
    return (solid ? solid->parts() : assembly.complete_parts()) - encoded_parts;
  }
};

struct State {
  float quantized_isovalue = 0;
  uint32_t level = 0;
  VolumeGrid grid;
  std::optional<SurfaceExtent> extent;
  std::optional<MeshToFile> file;
  ChunkDecoder decoder;
  DecodedCells cells;
  BlockMesher mesher;
  BlockMesh mesh;
  EncodedPart part;
  std::vector<std::byte> header;
  std::array<double, 3> numbers{};
  std::string error;
};

State& state() {
  static State instance;
  return instance;
}

IsosplatStatus report(const Error& error) {
  state().error = error.message;
  return static_cast<IsosplatStatus>(error.status);
}

IsosplatStatus report(const Result<void>& result) {
  return result ? 0 : report(result.error());
}

VolumeGrid grid_of(const IsosplatVolume& volume) {
  VolumeGrid grid;
  const auto vector = [](const double* n) { return Vec3d{n[0], n[1], n[2]}; };
  grid.voxels = {static_cast<int32_t>(volume.voxels[0]), static_cast<int32_t>(volume.voxels[1]),
                 static_cast<int32_t>(volume.voxels[2])};
  grid.spacing = vector(volume.spacing);
  grid.origin = vector(volume.origin);
  for (size_t i = 0; i < 9; ++i) grid.direction[i] = volume.direction[i];
  return grid;
}

Index3 index_of(const uint32_t* n) {
  return {static_cast<int32_t>(n[0]), static_cast<int32_t>(n[1]), static_cast<int32_t>(n[2])};
}

void begin(uint32_t level, float quantized_isovalue) {
  State& s = state();
  s.extent.reset();
  s.file.reset();
  s.level = level;
  s.mesher.keep_off_lattice_points(0);
  s.quantized_isovalue = quantized_isovalue;
}

Result<void> complete_layer(MeshToFile& file) {
  file.assembly.drop_complete();
  file.encoded_parts = 0;
  if (auto added = file.assembly.add_layer(std::exchange(file.layer, {})); !added) return added;
  for (size_t i = 0; file.solid && i < file.assembly.complete_parts(); ++i) {
    append_part(file.solid->mesh, file.assembly.take_part(i));
  }
  return {};
}

/// Completes and closes the mesh of a solid.
Result<void> complete_solid(MeshToFile& file) {
  for (int layer = 0; layer < 2; ++layer) {
    if (auto completed = complete_layer(file); !completed) return completed;
  }
  file.assembly.drop_complete();
  file.solid->is_complete = true;
  return file.solid->region.close(file.solid->mesh);
}

/// At the end, completes the next layer when all parts of the one before are encoded.
Result<void> complete_last_layers(MeshToFile& file) {
  while (file.layers_to_complete > 0 && file.parts_left() == 0) {
    --file.layers_to_complete;
    if (auto completed = complete_layer(file); !completed) return completed;
  }
  return {};
}

/// Adds the block of the decoded cells.
Result<void> add_block(MeshToFile& file, Index3 origin, Index3 block_cells) {
  State& s = state();
  if (!file.layer.empty() && file.layer.front().origin.z != origin.z) {
    if (auto completed = complete_layer(file); !completed) return completed;
  }
  if (file.region) file.region->keep(s.cells, origin, s.level);
  MeshedBlock& block = file.layer.emplace_back();
  block.origin = origin;
  s.mesher.run(s.cells, block_cells, origin, s.quantized_isovalue, block.mesh);
  return {};
}

std::span<const std::byte> buffer_of(uint32_t buffer) {
  const State& s = state();
  switch (buffer) {
    case ISOSPLAT_MESH_BODY:
      return s.part.body;
    case ISOSPLAT_MESH_TAIL:
      return s.part.tail;
    case ISOSPLAT_MESH_HEADER:
      return s.header;
    case ISOSPLAT_MESH_NUMBERS:
      return std::as_bytes(std::span(s.numbers));
    default:
      return {};
  }
}

}  // namespace

const char* isosplat_mesh_error(void) {
  return state().error.c_str();
}

const char* isosplat_mesh_status_name(IsosplatStatus status) {
  // The names are literals, which end in a null.
  return status_name(static_cast<Status>(status)).data();
}

const void* isosplat_mesh_result(uint32_t buffer) {
  return buffer_of(buffer).data();
}

uint32_t isosplat_mesh_result_bytes(uint32_t buffer) {
  return static_cast<uint32_t>(buffer_of(buffer).size());
}

IsosplatStatus isosplat_mesh_begin_extent(const IsosplatVolume* volume, float quantized_isovalue,
                                          uint32_t lowest_quantized) {
  begin(0, quantized_isovalue);
  state().extent.emplace(grid_of(*volume), quantized_isovalue,
                         static_cast<QuantizedValue>(lowest_quantized));
  return 0;
}

IsosplatStatus isosplat_mesh_begin_file(const IsosplatVolume* volume, uint32_t level,
                                        float quantized_isovalue, uint32_t format,
                                        const char* comment, uint32_t comment_bytes) {
  begin(level, quantized_isovalue);
  const VolumeGrid& grid = state().grid = grid_of(*volume);
  auto encoder = make_mesh_encoder(static_cast<MeshFormatId>(format), grid,
                                   std::string_view(comment, comment_bytes));
  if (!encoder) {
    return report(
        Error{Status::invalid_argument,
              "expected the number of a mesh format, 0 to 2, found " + std::to_string(format)});
  }
  state().file.emplace(
      MeshToFile{.assembly = MeshAssembly(grid, level), .encoder = std::move(encoder)});
  return 0;
}

IsosplatStatus isosplat_mesh_set_region(const double* box) {
  auto& file = state().file;
  if (!file) return report(Error{Status::invalid_argument, "there is no file: begin one first"});
  file->region = CellRegion::in_grid({box[0], box[1], box[2]}, {box[3], box[4], box[5]});
  return 0;
}

IsosplatStatus isosplat_mesh_close(const double* box, const double* planes, uint32_t plane_count) {
  State& s = state();
  if (!s.file) return report(Error{Status::invalid_argument, "there is no file: begin one first"});
  SolidRegion region(s.grid, s.level);
  auto clipped = region.clip_to_voxels({box[0], box[1], box[2]}, {box[3], box[4], box[5]});
  for (uint32_t i = 0; clipped && i < plane_count; ++i) {
    const double* plane = planes + 4 * i;
    clipped = region.clip({{plane[0], plane[1], plane[2]}, plane[3]});
  }
  if (!clipped) return report(clipped);
  const CellRegion cells = region.cells();
  auto encoder = std::move(s.file->encoder);
  s.file.emplace(MeshToFile{.assembly = MeshAssembly(lattice_grid(s.grid.voxels), s.level),
                            .encoder = std::move(encoder),
                            .region = cells,
                            .solid = Solid{.region = std::move(region)}});
  s.mesher.keep_off_lattice_points(SolidRegion::kLeastDistance);
  return 0;
}

IsosplatStatus isosplat_mesh_add(const void* data, uint32_t bytes, const IsosplatChunkShape* shape,
                                 uint32_t checksum) {
  State& s = state();
  if ((!s.extent && !s.file) || shape->level != s.level) {
    return report(Error{Status::invalid_argument,
                        "expected a chunk of the level that was begun, found another"});
  }
  if (static_cast<uint32_t>(XXH3_64bits(data, bytes)) != checksum) {
    return report(Error{Status::checksum_mismatch, "a chunk's checksum differs"});
  }
  const Index3 cells = index_of(shape->block_cells), block = index_of(shape->block);
  const ChunkShape of_chunk{cells, shape->band_begin, shape->band_end, shape->cells,
                            shape->level > 0};
  const std::span chunk(static_cast<const std::byte*>(data), bytes);
  if (const auto ok = s.decoder.decode(chunk, of_chunk, s.cells); !ok) return report(ok);
  const Index3 origin{block.x * kBlockCells, block.y * kBlockCells, block.z * kBlockCells};
  if (s.file) return report(add_block(*s.file, origin, cells));
  s.mesher.run(s.cells, cells, origin, s.quantized_isovalue, s.mesh);
  s.extent->add(s.cells, s.mesh, origin);
  return 0;
}

uint32_t isosplat_mesh_parts_left(void) {
  const auto& file = state().file;
  return file ? static_cast<uint32_t>(file->parts_left()) : 0;
}

IsosplatStatus isosplat_mesh_encode_part(void) {
  State& s = state();
  s.part.body.clear();
  s.part.tail.clear();
  if (isosplat_mesh_parts_left() == 0) return 0;
  MeshToFile& file = *s.file;
  const size_t i = file.encoded_parts++;
  const MeshPart part = file.solid ? file.solid->part(i) : file.assembly.take_part(i);
  if (auto encoded = file.encoder->append(part, s.part); !encoded) return report(encoded);
  return file.solid ? 0 : report(complete_last_layers(file));
}

IsosplatStatus isosplat_mesh_finish(void) {
  auto& file = state().file;
  if (!file) return 0;
  if (file->solid) return report(complete_solid(*file));
  file->layers_to_complete = 2;
  return report(complete_last_layers(*file));
}

IsosplatStatus isosplat_mesh_summary(void) {
  State& s = state();
  if (s.extent) {
    s.numbers = {s.extent->area(), s.extent->volume_above(), s.extent->grid_volume()};
  } else if (s.file) {
    const MeshCounts counts = s.file->solid
                                  ? MeshCounts{s.file->solid->mesh.vertices.positions.size(),
                                               s.file->solid->mesh.triangles.size()}
                                  : s.file->assembly.counts();
    s.header = s.file->encoder->header();
    s.numbers = {static_cast<double>(counts.vertices), static_cast<double>(counts.triangles), 0};
  }
  return 0;
}
