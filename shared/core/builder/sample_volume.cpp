#include "shared/core/builder/sample_volume.h"

#include <algorithm>

#include "shared/core/builder/executor.h"
#include "shared/core/builder/quantized_reader.h"

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

/// The block in the middle of the `stride` blocks that a column represents.
int32_t sampled_block(const VolumeSample& sample, int32_t column, int32_t blocks) {
  return std::min(column * sample.stride + sample.stride / 2, blocks - 1);
}

/// Appends rows [first_row, end_row) of columns of one layer, which has their voxels.
void sample_layer(VolumeSample& sample, const Layer& layer, Index3 blocks, int32_t first_row,
                  int32_t end_row, Executor& executor, std::vector<GatheredBlock>& scratch) {
  const auto across = static_cast<size_t>(sample.columns_across.x);
  const size_t columns = across * static_cast<size_t>(end_row - first_row);
  const size_t base = sample.columns.size();
  sample.columns.resize(base + columns);
  executor.run(columns, [&](unsigned thread, size_t i) {
    const auto x = static_cast<int32_t>(i % across);
    const auto y = first_row + static_cast<int32_t>(i / across);
    sample.columns[base + i] = sample_column(
        layer, {sampled_block(sample, x, blocks.x), sampled_block(sample, y, blocks.y), 0},
        scratch[thread]);
  });
}

/// Large slices are read in parts of about this size, if the source reads rows.
constexpr size_t kPartBytes = 4 << 20;

}  // namespace

Result<VolumeSample> sample_volume(VolumeSource& source, const Quantization& quantization,
                                   Executor& executor) {
  const VolumeHeader& header = source.header();
  const ValueMapping& mapping = quantization.mapping();
  const Index3 n = header.grid.voxels;
  const int32_t counted = std::min(kSlices, n.z);
  const int32_t depth = std::min(kDepth, n.z - 1);
  const Index3 blocks = level_grid(n, 0).blocks;

  VolumeSample sample;
  choose_columns(sample, blocks, n.z - 1, depth);

  SerialExecutor serial;
  QuantizedReader reader(source, quantization, serial);
  const int32_t part_rows = rows_per_read(source, kPartBytes);
  const bool is_whole = part_rows == n.y;
  std::vector<std::byte> values;
  std::vector<GatheredBlock> scratch(executor.threads());
  int32_t next_counted = 0, next_layer = 0;
  // Slices are read in ascending order, and counted where whole layers have them.
  const auto count = [&](unsigned, const SliceRows& part, const std::byte* quantized_values) {
    if (next_counted == counted || part.first_slice != middle(next_counted, counted, n.z)) return;
    const size_t voxels = part.voxels(n.x);
    sample.statistics.add_values(quantized_values, voxels, mapping.bits, mapping.has_missing);
    sample.voxels += voxels;
    if (part.first_row + part.rows == n.y) ++next_counted;
  };
  const auto count_nothing = [](unsigned, const SliceRows&, const std::byte*) {};
  const auto read = [&](const SliceRows& part, bool counts) {
    values.resize(part.voxels(n.x) * mapping.bits / 8);
    return counts ? reader.read(part, values.data(), count)
                  : reader.read(part, values.data(), count_nothing);
  };
  while (next_counted < counted || next_layer < sample.columns_across.z) {
    // Each layer is in the middle of its part of the z axis.
    const int32_t layer_begin =
        next_layer < sample.columns_across.z
            ? std::clamp(middle(next_layer, sample.columns_across.z, n.z) - depth / 2, 0,
                         n.z - 1 - depth)
            : n.z;
    const int32_t slice = next_counted < counted ? middle(next_counted, counted, n.z) : n.z;
    if (slice < layer_begin) {
      for (int32_t y = 0; y < n.y; y += part_rows) {
        auto done = read({slice, 1, y, std::min(part_rows, n.y - y)}, true);
        if (!done) return tl::unexpected(done.error());
      }
      continue;
    }
    ++next_layer;
    Layer layer;
    layer.grid = level_grid({n.x, n.y, depth + 1}, 0);
    layer.bits = mapping.bits;
    layer.has_missing = mapping.has_missing;
    const int32_t rows = sample.columns_across.y;  // of columns
    for (int32_t row = 0; row < rows; row += is_whole ? rows : 1) {
      SliceRows part{layer_begin, depth + 1, 0, n.y};
      if (!is_whole) {
        part.first_row = sampled_block(sample, row, blocks.y) * kBlockCells;
        part.rows = std::min(kBlockCells + 1, n.y - part.first_row);
      }
      if (auto done = read(part, is_whole); !done) return tl::unexpected(done.error());
      layer.voxels = values.data();
      layer.voxel_box = {{0, part.first_row, 0}, {n.x, part.rows, depth + 1}};
      sample_layer(sample, layer, blocks, row, is_whole ? rows : row + 1, executor, scratch);
    }
  }
  return sample;
}

}  // namespace isosplat
