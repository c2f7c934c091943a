#include "shared/wasm/measure_api.h"

#include <optional>
#include <span>

#include "shared/codec/chunk_codec.h"
#include "shared/mesh/block_mesh.h"
#include "shared/mesh/surface_extent.h"
#define XXH_INLINE_ALL
#include "xxhash.h"

using namespace isosplat;

namespace {

struct State {
  std::optional<SurfaceExtent> extent;
  float quantized_isovalue = 0;
  ChunkDecoder decoder;
  DecodedCells cells;
  BlockMesher mesher;
  BlockMesh mesh;
};

State& state() {
  static State instance;
  return instance;
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

}  // namespace

void isosplat_measure_begin(const IsosplatVolume* volume, float quantized_isovalue,
                            uint32_t lowest_quantized) {
  state().extent.emplace(grid_of(*volume), quantized_isovalue,
                         static_cast<QuantizedValue>(lowest_quantized));
  state().quantized_isovalue = quantized_isovalue;
}

IsosplatStatus isosplat_measure_add(const void* data, uint32_t bytes,
                                    const IsosplatChunkShape* shape, uint32_t checksum) {
  State& s = state();
  const auto code = [](Status status) { return static_cast<IsosplatStatus>(status); };
  if (!s.extent || shape->level != 0) return code(Status::invalid_argument);
  const std::span chunk(static_cast<const std::byte*>(data), bytes);
  if (static_cast<uint32_t>(XXH3_64bits(data, bytes)) != checksum)
    return code(Status::checksum_mismatch);
  const auto index = [](const uint32_t* n) {
    return Index3{static_cast<int32_t>(n[0]), static_cast<int32_t>(n[1]),
                  static_cast<int32_t>(n[2])};
  };
  const Index3 cells = index(shape->block_cells), block = index(shape->block);
  const ChunkShape of_chunk{cells, shape->band_begin, shape->band_end, shape->cells, false};
  if (const auto ok = s.decoder.decode(chunk, of_chunk, s.cells); !ok) {
    return code(ok.error().status);
  }
  const Index3 origin{block.x * kBlockCells, block.y * kBlockCells, block.z * kBlockCells};
  s.mesher.run(s.cells, cells, origin, s.quantized_isovalue, s.mesh);
  s.extent->add(s.cells, s.mesh, origin);
  return 0;
}

void isosplat_measure_result(double* result) {
  const auto& extent = state().extent;
  result[0] = extent ? extent->area() : 0;
  result[1] = extent ? extent->volume_above() : 0;
  result[2] = extent ? extent->grid_volume() : 0;
}
