#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "shared/core/select/selector.h"
#include "tests/shared/store_fixture.h"

namespace isosplat::fixture {

inline constexpr Index3 kVoxels{300, 200, 150};

/// A volume with empty parts: two balls of different size with rough surfaces, whose values are at
/// most 607, and 0 to 7 elsewhere.
inline QuantizedValue two_balls(int32_t x, int32_t y, int32_t z) {
  const auto ball = [&](int32_t cx, int32_t cy, int32_t cz, int32_t radius) {
    const int32_t dx = x - cx, dy = y - cy, dz = z - cz;
    return 600 - 600 * (dx * dx + dy * dy + dz * dz) / (radius * radius);
  };
  const int32_t hash =
      static_cast<int32_t>(static_cast<uint32_t>(x * 31 + y * 17 + z * 7) * 2654435761u >> 29);
  return static_cast<QuantizedValue>(std::max({0, ball(70, 80, 70, 60), ball(240, 130, 90, 25)}) +
                                     hash);
}

/// A view of the volume's centre from a direction (radians) and a distance.
inline SelectionView view_from(double distance, double azimuth, double elevation,
                               float quantized_isovalue, double pixels = 512) {
  const VolumeGrid grid{kVoxels, {1, 1, 1.5}, {-10, 20, 30}};
  const Vec3d centre = grid.world({150, 100, 75});
  const Vec3d out{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                  std::sin(elevation)};
  const Vec3d eye = centre + out * distance;
  const Vec3d right{-std::sin(azimuth), std::cos(azimuth), 0};
  const Vec3d up = cross(out, right);
  const double focal = 1 / std::tan(std::numbers::pi / 8);
  const double near = 0.5, far = 5000;
  const double a = (far + near) / (near - far), b = 2 * far * near / (near - far);
  const Vec3d rows[3] = {right, up, out};
  SelectionView view;
  for (size_t row = 0; row < 4; ++row) {
    const Vec3d axis = row < 3 ? rows[row] : out * -1.0;
    const double scale = row < 2 ? focal : row == 2 ? a : 1;
    const double shift = -dot(axis, eye) * scale + (row == 2 ? b : 0);
    view.view_projection[row] = axis.x * scale;
    view.view_projection[4 + row] = axis.y * scale;
    view.view_projection[8 + row] = axis.z * scale;
    view.view_projection[12 + row] = shift;
  }
  view.width_px = view.height_px = pixels;
  view.quantized_isovalues = {quantized_isovalue};
  return view;
}

class SelectTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    levels_ = new std::vector<fixture::Level>(fixture::make_levels(kVoxels, two_balls));
    bytes_ = new std::vector<std::byte>(fixture::make_store(*levels_, 40));
  }
  static void TearDownTestSuite() {
    delete levels_;
    delete bytes_;
  }

  StoreReader open() const { return fixture::open_store(*bytes_); }

  static bool in_frustum(const SelectionView& view, Vec3d world) {
    double clip[4];
    for (size_t row = 0; row < 4; ++row) {
      clip[row] = view.view_projection[row] * world.x + view.view_projection[4 + row] * world.y +
                  view.view_projection[8 + row] * world.z + view.view_projection[12 + row];
    }
    return std::abs(clip[0]) <= clip[3] && std::abs(clip[1]) <= clip[3] &&
           std::abs(clip[2]) <= clip[3];
  }

  /// The active cells of level 0.
  static const std::vector<Index3>& active_cells(float quantized_isovalue) {
    static std::map<float, std::vector<Index3>> known;
    const auto [place, added] = known.try_emplace(quantized_isovalue);
    const fixture::Level& finest = (*levels_)[0];
    for (int32_t z = 0; added && z < finest.grid.cells.z; ++z) {
      for (int32_t y = 0; y < finest.grid.cells.y; ++y) {
        for (int32_t x = 0; x < finest.grid.cells.x; ++x) {
          if (is_active(finest.intervals[finest.cell(x, y, z)], quantized_isovalue)) {
            place->second.push_back({x, y, z});
          }
        }
      }
    }
    return place->second;
  }

  /// How often each active cell of level 0 is drawn, as itself or as part of a coarser cell. Does
  /// not count cells outside of the frustum.
  static std::map<int, int> coverage(const StoreReader& store, const Selector& selector,
                                     const SelectionView& view, const Selection& selection) {
    std::map<std::tuple<uint32_t, int, int, int>, RegionMask> regions;
    for (const DrawnChunk& chunk : selection.draw) {
      const BlockKey key = selector.chunk(chunk.handle)->block;
      regions[{key.level, key.index.x, key.index.y, key.index.z}] |= chunk.regions;
    }
    std::map<int, int> times;
    for (const Index3 cell : active_cells(view.quantized_isovalues[0])) {
      const Vec3d centre{cell.x + 0.5, cell.y + 0.5, cell.z + 0.5};
      if (!in_frustum(view, store.info().grid.world(centre))) continue;
      int count = 0;
      for (uint32_t l = 0; l < levels_->size(); ++l) {
        const Index3 c{cell.x >> l, cell.y >> l, cell.z >> l};
        const auto found = regions.find({l, c.x >> 6, c.y >> 6, c.z >> 6});
        if (found == regions.end()) continue;
        count += found->second.contains({c.x >> 3 & 7, c.y >> 3 & 7, c.z >> 3 & 7});
      }
      ++times[count];
    }
    return times;
  }

  /// Makes all chunks of the coarsest levels resident, as a client does when it opens a store.
  void load_coarse(const StoreReader& store, Selector& selector, uint32_t from) const {
    for (uint32_t l = from; l < store.info().levels; ++l) {
      const std::vector<ChunkRef> chunks = *store.chunks_for(l, 0, 65535);
      for (const ChunkRef& chunk : chunks) {
        ASSERT_TRUE(selector.set_resident(selector.handle_of(chunk), true));
      }
    }
  }

  static inline std::vector<fixture::Level>* levels_ = nullptr;
  static inline std::vector<std::byte>* bytes_ = nullptr;
};

}  // namespace isosplat::fixture
