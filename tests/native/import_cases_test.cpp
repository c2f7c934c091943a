#include <algorithm>
#include <cmath>

#include "tests/native/import_checks.h"

// Files that follow conventions of other programs and that an earlier version read wrongly, each
// with its expected result. The files are beside the checkout; if they are missing, the test is
// skipped.
namespace isosplat::import {
namespace {

using test::error_of;
using test::read_all;

struct Case {
  const char* name;
  ImportOptions options;
  const char* error;  ///< a part of the error; empty: the volume is read
  Index3 size{};
  Vec3d spacing{};                 ///< millimetres
  double least = 0, greatest = 0;  ///< of its values, if they differ
  const char* note = "";           ///< a part of a note
};

ImportOptions with_channel(uint64_t channel) {
  ImportOptions options;
  options.channel = channel;
  return options;
}

ImportOptions with_time(uint64_t time) {
  ImportOptions options;
  options.time_step = time;
  return options;
}

ImportOptions with_frames() {
  ImportOptions options;
  options.allowed.add(Allowance::frames);
  return options;
}

constexpr Index3 kSize{8, 7, 6};
constexpr Vec3d kUnit{1, 1, 1};
constexpr double kAngstrom = 1e-7;

const Case kCases[] = {
    {"t_shaped4.tif", {}, "--time-step 0 to --time-step 1"},
    {"t_shaped4.tif", with_time(1), "", kSize, kUnit},
    {"t_ome_prefix.ome.tif", {}, "--channel 0 to --channel 1"},
    {"t_ome_prefix.ome.tif", with_channel(1), "", kSize, {}},
    {"t_ome_binaryonly.ome.tif", {}, "x.companion.ome"},
    {"e_tiff_vol4.tif", {}, "2 × 16 planes"},
    {"e_tiff_vol4.tif", with_time(1), "", {16, 16, 16}, kUnit},
    {"t_gdal_fmin.tif", {}, "", kSize, kUnit, -271.12854, 96.215469},
    {"h_bdv.h5", {}, "", kSize, kUnit, 381, 65420},
    {"h_nc_unsigned.nc", {}, "", kSize, kUnit, 0, 255},
    {"h_ims_1.ims", {}, "", kSize, {0.0005, 0.0005, 0.002}, 23, 3993},
    {"e_wsi_tiles.dcm", {}, "whole-slide image"},
    {"e_pm_int.dcm", {}, "", kSize, {0.5, 0.6, 2}, -4.977, -1.007},
    {"d_rwvm.dcm", {}, "", kSize, {0.5, 0.6, 2}, -3106.7054, 2985.4582},
    {"m_mode0_4bit_flag.mrc", {}, "", kSize, {kAngstrom, kAngstrom, kAngstrom}, 0, 15},
    {"m_ccp4_skew.mrc", {}, "", kSize, {}, 0, 0, "LSKFLG"},
    {"m_mode0_stalerange.mrc",
     {},
     "",
     kSize,
     {},
     0,
     0,
     "does not say whether its bytes are signed"},
    {"e_labelmap.dcm", {}, "", {10, 9, 8}, {0.5, 0.6, 2}, 0, 2},
    {"e_labelmap1.dcm", {}, "", {10, 9, 8}, {0.5, 0.6, 2}, 0, 1},
    {"k_labels255.nii", {}, "", {16, 16, 16}, kUnit, 0, 255},
    {"k_noise1000.nii", {}, "", {16, 16, 16}, kUnit, 1.3601258e-05, 1000},
    {"k_prob.nii", {}, "", {16, 16, 16}, kUnit, 5.6056871e-07, 1},
    {"h_nc_coords.nc", {}, "", kSize, {0.25, 0.5, 2}},
    {"e_nc_desc.nc", {}, "", kSize, {0.25, 0.5, 2}},
    {"h_vtkhdf.vtkhdf", {}, "", kSize, {0.25, 0.5, 2}},
    {"h_emd.emd", {}, "", kSize, {0.25e-6, 0.5e-6, 2e-6}},
    {"h_nc_missing.nc", {}, "", kSize, kUnit, -2960, 3475},
    {"h_mat73.mat", {}, "", {7, 8, 6}, kUnit, 23, 3993, "MATLAB"},
    {"t_ij_nospacing.tif", {}, "", kSize, {0.0001, 0.0001, 0.001}},
    {"t_ome_noz.ome.tif", {}, "", kSize, {0.0001, 0.0001, 0.001}},
    {"t_ome_unit_ent.ome.tif", {}, "", kSize, {0.0005, 0.0005, 0.002}},
    {"t_ome_prefix1.ome.tif", {}, "", kSize, {0.0005, 0.0005, 0.002}},
    {"e_lsm.lsm", {}, "", kSize, {0.0005, 0.0005, 0.002}},
    {"f_nm_noori.dcm", {}, "", kSize, {3, 4, 4.5}, 0, 0, "orientation"},
    {"t_stk.stk", {}, "", kSize, {}, 23, 3993},
    {"t_shaped_trunc.tif", {}, "", kSize, {}, 23, 3993},
    {"t_volumetric.tif", {}, "", {16, 16, 6}, {}, 0, 3993},
    {"t_ome_multi", {}, "", kSize, {0.0005, 0.0005, 0.002}, 23, 3993},
    {"f_sparse.tif", {}, "", {16, 16, 3}, kUnit, 0, 257},
    {"t_ij_frames.tif", {}, "--allow-frames"},
    {"t_ij_frames.tif", with_frames(), "", kSize, {}},
    {"e_ij_default.tif", {}, "--allow-frames"},
    {"e_ij_default.tif", with_frames(), "", kSize, {}},
    {"f_seg_sparse.dcm", {}, "", kSize, {0.5, 0.6, 2}, 0, 251},
    {"ome.zarr", {}, "", kSize, {0.0005, 0.0005, 0.002}},
    {"n_bz2.nii.bz2", {}, "", kSize, {}, -2960, 3988},
    {"h_nc3.nc", {}, "", kSize, kUnit, -271.12854, 310.00424, "1,1,1 is assumed"},
    {"lfs.nrrd", {}, "git lfs pull"},
};

TEST(ImportCases, EachFileIsReadAsItDescribesItself) {
  const auto folder = std::filesystem::path(ISOSPLAT_SOURCE_DIR) / "../shared/cases/import";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  for (const Case& each : kCases) {
    SCOPED_TRACE(each.name);
    const std::string error = error_of(folder / each.name, each.options);
    if (*each.error) {
      EXPECT_NE(error.find(each.error), error.npos) << error;
      continue;
    }
    ASSERT_EQ(error, "");
    const OpenVolume volume = test::open(folder / each.name, each.options);
    const VolumeGrid& grid = volume.source->header().grid;
    EXPECT_EQ(grid.voxels, each.size);
    if (each.spacing.x > 0) {
      const Vec3d spacing = grid.spacing;
      EXPECT_NEAR(spacing.x, each.spacing.x, 1e-6 * each.spacing.x);
      EXPECT_NEAR(spacing.y, each.spacing.y, 1e-6 * each.spacing.y);
      EXPECT_NEAR(spacing.z, each.spacing.z, 1e-6 * each.spacing.z);
    }
    if (each.least < each.greatest) {
      auto values = read_all(*volume.source);
      std::erase_if(values, [](double value) { return std::isnan(value); });
      const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
      EXPECT_NEAR(*least, each.least, 1e-4 * (each.greatest - each.least));
      EXPECT_NEAR(*greatest, each.greatest, 1e-4 * (each.greatest - each.least));
    }
    if (*each.note) test::expect_note(volume, each.note);
  }
}

}  // namespace
}  // namespace isosplat::import
