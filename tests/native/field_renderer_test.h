#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "native/headless/draw_image.h"
#include "shared/core/sampling/packed_field.h"
#include "shared/core/sampling/sample_clusters.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

// A volume and a field on the same voxels, and the field's value at the position of each pixel.
namespace isosplat::render {

inline constexpr int kSize = 280;
inline constexpr double kIsovalue = 1800;
using Field = SurfacePixel::Field;

/// A ball with waves on it, around the middle of 48³ cells.
inline double bumpy(Vec3d p) {
  const Vec3d from_middle = p - Vec3d{24, 24, 24};
  return 100 * length(from_middle) + 80 * std::sin(0.5 * p.x) * std::cos(0.4 * p.y + 0.3 * p.z);
}

/// The second scalar. Not linear in a cell, and of another size than the volume's values.
inline double pressure(Vec3d p) {
  return 30000 + 8000 * std::sin(0.21 * p.x + 0.1 * p.y) * std::cos(0.17 * p.z) + 90 * p.y;
}

/// The voxels of a level.
inline TestVolume at_level(const TestVolume& finest, uint32_t level) {
  TestVolume volume = finest;
  for (uint32_t i = 0; i < level; ++i) volume = coarser_volume(volume);
  return volume;
}

/// The values of a field for samples of block (0, 0, 0), in their order in the GPU's memory.
inline std::vector<PackedField> values_for(const TestVolume& field_at_level,
                                           const std::vector<PackedSample>& samples) {
  std::vector<PackedSample> ordered;
  cluster_samples(samples, ordered);
  std::vector<PackedField> values;
  for (const PackedSample& sample : ordered) {
    const Index3 cell = unpack_sample(sample).cell;
    values.push_back(pack_field(corners_at(field_at_level, cell.x, cell.y, cell.z)));
  }
  return values;
}

class FieldRendererTest : public RendererTest {
 protected:
  void prepare() override {
    settings_.eye_dome = 0;
    settings_.isosurfaces = {{kIsovalue, {0.1f, 0.8f, 0.2f}, 1}};
    settings_.colour_by = ColourBy::field;
    mapping_.offset = -300;
    mapping_.scale = 0.01;
    settings_.colour_low = mapping_.value(20000);
    settings_.colour_high = mapping_.value(44000);
  }

  /// Shows block (0, 0, 0) of a level of the volume, and with `values` those of the field.
  void show(const TestVolume& volume, const TestVolume& field, uint32_t level = 0,
            bool values = true, VolumeId id = 0) {
    volume_ = volume;
    level_ = level;
    field_ = at_level(field, level);
    renderer_->set_volume(volume.grid, volume.mapping, id);
    samples_ = block_samples(volume, {level, {0, 0, 0}}, kIsovalue, kIsovalue);
    ASSERT_TRUE(renderer_->add_chunk(kHandle, {level, {0, 0, 0}}, samples_, id));
    renderer_->set_visible({&kHandle, 1}, id);
    if (values) {
      ASSERT_TRUE(renderer_->set_field(mapping_, id));
      const auto set = renderer_->set_chunk_field(kHandle, values_for(field_, samples_), id);
      ASSERT_TRUE(set) << set.error().message;
    }
    camera_ = default_camera(volume.grid);
    camera_.azimuth = 25;
    camera_.elevation = 20;
  }

  Image draw(const std::string& name, bool still = false) {
    return draw_and_keep(settings_, camera_, kSize, "field-" + name, still);
  }

  std::vector<SurfacePixel> pixels() { return renderer_->read_surface().value(); }

  /// The position of a pixel of read_surface, in voxels of level 0.
  Vec3d voxel_at(size_t index, double depth) {
    const CameraFrame frame = camera_frame(camera_);
    const double px = 2 * frame.half_height(1) / kSize;
    const double x = double(index % kSize) + 0.5 - 0.5 * kSize;
    const double y = double(index / kSize) + 0.5 - 0.5 * kSize;
    const Vec3d aside = frame.right * (x * px) + frame.up * (y * px);
    const Vec3d at = frame.orthographic ? frame.eye + aside + frame.forward * depth
                                        : frame.eye + (frame.forward + aside) * depth;
    return multiply_transposed(volume_.grid.dual_edges(), at - volume_.grid.origin);
  }

  /// The field's quantized value at a position: trilinear between the voxels of the level.
  double field_at(Vec3d voxel) const {
    const double cells = std::ldexp(1.0, -static_cast<int>(level_));
    const Index3 n = field_.grid.voxels;
    const double p[3] = {voxel.x * cells, voxel.y * cells, voxel.z * cells};
    const int32_t last[3] = {n.x - 2, n.y - 2, n.z - 2};
    int32_t low[3];
    double t[3];
    for (int i = 0; i < 3; ++i) {
      low[i] = std::clamp(static_cast<int32_t>(std::floor(p[i])), 0, last[i]);
      t[i] = p[i] - low[i];
    }
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      const int at[3] = {c & 1, c >> 1 & 1, c >> 2};
      double weight = 1;
      for (int i = 0; i < 3; ++i) weight *= at[i] ? t[i] : 1 - t[i];
      sum += weight * double(field_.at(low[0] + at[0], low[1] + at[1], low[2] + at[2]));
    }
    return sum;
  }

  struct Comparison {
    int values = 0, missing = 0, none = 0;
    double most = 0;     ///< largest difference, in the field's quantized values
    double outside = 0;  ///< largest position in the colour map outside of 0.02 … 0.98
  };

  /// Compares the value that each pixel shows with the field at the pixel's position.
  Comparison compare() {
    Comparison c;
    const double low = (settings_.colour_low - mapping_.offset) / mapping_.scale;
    const double high = (settings_.colour_high - mapping_.offset) / mapping_.scale;
    const auto found = pixels();
    for (size_t i = 0; i < found.size(); ++i) {
      const SurfacePixel& pixel = found[i];
      if (!pixel.hit) continue;
      c.missing += pixel.field == Field::missing;
      c.none += pixel.field == Field::none;
      if (pixel.field != Field::value) continue;
      ++c.values;
      const double shown = low + double(pixel.scalar) * (high - low);
      const double expected = field_at(voxel_at(i, double(pixel.depth)));
      c.most = std::max(c.most, std::abs(shown - expected));
    }
    return c;
  }

  RenderSettings settings_;
  Camera camera_;
  ValueMapping mapping_;  // of the field
  TestVolume volume_, field_;
  std::vector<PackedSample> samples_;
  uint32_t level_ = 0;
  static constexpr ChunkHandle kHandle = 5;
};

inline TestVolume ball() {
  return sampled_volume({49, 49, 49}, {1, 1, 1}, bumpy);
}
inline TestVolume pressures() {
  return sampled_volume({49, 49, 49}, {1, 1, 1}, pressure);
}

}  // namespace isosplat::render
