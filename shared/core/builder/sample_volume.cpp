#include "shared/core/builder/sample_volume.h"

#include <algorithm>

#include "shared/core/builder/executor.h"

namespace isosplat {
namespace {

constexpr int32_t kSlices = 24;    ///< number of slices whose values are counted
constexpr int32_t kDepth = 4;      ///< slices of cells in a column
constexpr int32_t kLayers = 12;    ///< of columns, at most
constexpr int32_t kColumns = 192;  ///< at most

/// The middle of part i of [0, n), divided into `count` equal parts.
int32_t middle(int32_t i, int32_t count, int32_t n) {
  return static_cast<int32_t>((2 * int64_t{i} + 1) * n / (2 * count));
}

/// How many columns of cells are sampled along each axis, at most kColumns in all.
void choose_columns(VolumeSample& sample, Index3 blocks, int32_t cells_z, int32_t depth) {
  // A single layer of blocks is sampled at several depths, as no other layer can represent it.
  sample.layers_per_block = blocks.z == 1 ? std::clamp(cells_z / (2 * depth), 1, 4) : 1;
  sample.columns_across.z = std::min(blocks.z, kLayers) * sample.layers_per_block;
  const auto across = [&](int32_t count) { return (count + sample.stride - 1) / sample.stride; };
  while (int64_t{across(blocks.x)} * across(blocks.y) * sample.columns_across.z > kColumns) {
    ++sample.stride;
  }
  sample.columns_across.x = across(blocks.x);
  sample.columns_across.y = across(blocks.y);
}

/// Appends the columns of one layer, each in the middle of the stride × stride blocks that it
/// represents.
void sample_layer(VolumeSample& sample, const Layer& layer, Index3 blocks, Executor& executor,
                  std::vector<GatheredBlock>& scratch) {
  const size_t columns =
      static_cast<size_t>(sample.columns_across.x) * static_cast<size_t>(sample.columns_across.y);
  const size_t base = sample.columns.size();
  sample.columns.resize(base + columns);
  executor.run(columns, [&](unsigned thread, size_t i) {
    const auto column = static_cast<int32_t>(i);
    const auto block_at = [&](int32_t index, int32_t count) {
      return std::min(index * sample.stride + sample.stride / 2, count - 1);
    };
    sample.columns[base + i] =
        sample_column(layer,
                      {block_at(column % sample.columns_across.x, blocks.x),
                       block_at(column / sample.columns_across.x, blocks.y), 0},
                      scratch[thread]);
  });
}

}  // namespace

Result<VolumeSample> sample_volume(VolumeSource& source, const Quantization& quantization,
                                   Executor& executor) {
  const VolumeHeader& header = source.header();
  const ValueMapping& mapping = quantization.mapping();
  const Index3 n = header.grid.voxels;
  const auto slice_voxels = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
  const size_t slice_bytes = slice_voxels * mapping.bits / 8;
  const int32_t counted = std::min(kSlices, n.z);
  const int32_t depth = std::min(kDepth, n.z - 1);
  const Index3 blocks = level_grid(n, 0).blocks;

  VolumeSample sample;
  choose_columns(sample, blocks, n.z - 1, depth);

  // Voxels that have the size of quantized values are quantized in place.
  const bool in_place = voxel_bytes(header.type) * 8 == mapping.bits;
  std::vector<std::byte> staging(in_place ? 0 : slice_voxels * voxel_bytes(header.type));
  std::vector<std::byte> quantized_values(slice_bytes * static_cast<size_t>(depth + 1));
  std::vector<GatheredBlock> scratch(executor.threads());
  int32_t next_counted = 0, next_layer = 0;
  while (next_counted < counted || next_layer < sample.columns_across.z) {
    // Each layer is in the middle of its part of the z axis.
    const int32_t layer_begin =
        next_layer < sample.columns_across.z
            ? std::clamp(middle(next_layer, sample.columns_across.z, n.z) - depth / 2, 0,
                         n.z - 1 - depth)
            : n.z;
    const int32_t slice = next_counted < counted ? middle(next_counted, counted, n.z) : n.z;
    const bool is_layer = layer_begin <= slice;
    const int32_t first = is_layer ? layer_begin : slice, end = first + (is_layer ? depth + 1 : 1);
    for (int32_t z = first; z < end; ++z) {
      std::byte* const to = quantized_values.data() + slice_bytes * static_cast<size_t>(z - first);
      const std::span<std::byte> raw = in_place ? std::span(to, slice_bytes) : std::span(staging);
      if (auto read = source.read_slices(z, 1, raw); !read) return tl::unexpected(read.error());
      quantization.encode(raw, to);
      if (next_counted < counted && z == middle(next_counted, counted, n.z)) {
        sample.statistics.add_values(to, slice_voxels, mapping.bits, mapping.has_missing);
        sample.voxels += slice_voxels;
        ++next_counted;
      }
    }
    if (!is_layer) continue;
    ++next_layer;
    Layer layer;
    layer.grid = level_grid({n.x, n.y, depth + 1}, 0);
    layer.bits = mapping.bits;
    layer.has_missing = mapping.has_missing;
    layer.voxels = quantized_values.data();
    layer.voxel_box = voxel_slices(layer.grid, 0, depth + 1);
    sample_layer(sample, layer, blocks, executor, scratch);
  }
  return sample;
}

}  // namespace isosplat
