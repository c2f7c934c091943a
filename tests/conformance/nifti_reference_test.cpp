#include <gtest/gtest.h>
#include <nifti2_io.h>

#include <cmath>

#include "tests/conformance/compare.h"
#include "tests/native/test_files.h"

// Compares generated NIfTI files with libnifti, the library of the format's authors.
namespace isosplat::conformance {
namespace {

template <class T>
void append_values(const nifti_image& image, int64_t step, std::vector<double>& values) {
  const auto count = static_cast<size_t>(image.nx * image.ny * image.nz);
  const auto* voxels = static_cast<const T*>(image.data) + static_cast<size_t>(step) * count;
  const bool scales = std::isfinite(image.scl_slope) && image.scl_slope != 0;
  for (size_t i = 0; i < count; ++i) {
    const auto voxel = static_cast<double>(voxels[i]);
    values.push_back(scales ? image.scl_inter + image.scl_slope * voxel : voxel);
  }
}

Truth truth_of(const nifti_image& image, int64_t step) {
  Truth truth;
  truth.sizes = {static_cast<int>(image.nx), static_cast<int>(image.ny),
                 static_cast<int>(image.nz)};
  const nifti_dmat44& m = image.sform_code > 0 ? image.sto_xyz : image.qto_xyz;
  const double unit = image.xyz_units == NIFTI_UNITS_METER    ? 1000
                      : image.xyz_units == NIFTI_UNITS_MICRON ? 0.001
                                                              : 1;
  const auto column = [&](size_t i) {  // from RAS
    return Vec3d{-m.m[0][i] * unit, -m.m[1][i] * unit, m.m[2][i] * unit};
  };
  for (size_t i = 0; i < 3; ++i) truth.steps[i] = column(i);
  truth.origin = column(3);
  switch (image.datatype) {
    case NIFTI_TYPE_UINT8:
      append_values<uint8_t>(image, step, truth.values);
      break;
    case NIFTI_TYPE_INT8:
      append_values<int8_t>(image, step, truth.values);
      break;
    case NIFTI_TYPE_UINT16:
      append_values<uint16_t>(image, step, truth.values);
      break;
    case NIFTI_TYPE_INT16:
      append_values<int16_t>(image, step, truth.values);
      break;
    case NIFTI_TYPE_UINT32:
      append_values<uint32_t>(image, step, truth.values);
      break;
    case NIFTI_TYPE_INT32:
      append_values<int32_t>(image, step, truth.values);
      break;
    case NIFTI_TYPE_UINT64:
      append_values<uint64_t>(image, step, truth.values);
      break;
    case NIFTI_TYPE_INT64:
      append_values<int64_t>(image, step, truth.values);
      break;
    case NIFTI_TYPE_FLOAT32:
      append_values<float>(image, step, truth.values);
      break;
    default:
      append_values<double>(image, step, truth.values);
  }
  return truth;
}

TEST(NiftiReference, ItsOwnLibraryReadsTheSameVolume) {
  nifti_set_debug_level(0);
  int compared = 0;
  constexpr int kFiles = 100;
  for (int i = 0; i < kFiles; ++i) {
    Random random(static_cast<uint64_t>(5000 + i));
    const Sample sample = make_nifti(random);
    SCOPED_TRACE("seed " + std::to_string(5000 + i) + ": " + sample.text);
    const test::TempFolder folder;
    for (const auto& [name, content] : sample.files) test::write_file(folder / name, content);
    // libnifti detects compressed data only by the file's name.
    const std::string& bytes = sample.files.at(sample.main);
    if (sample.main == "v.nii" && bytes.starts_with("\x1f\x8b")) continue;
    nifti_image* image = nifti_image_read((folder / sample.main).c_str(), 1);
    if (!image || !image->data) continue;  // dim[4] = 0
    const Truth truth = truth_of(*image, sample.options.time_step.value_or(0));
    nifti_image_free(image);
    ++compared;
    auto volume = import::open_volume(folder / sample.main, sample.options);
    ASSERT_TRUE(volume) << volume.error().message;
    const auto values = read_values(*volume->source);
    ASSERT_TRUE(values) << values.error().message;
    EXPECT_EQ(difference(volume->source->header().grid, *values, truth), "");
  }
  EXPECT_GE(compared, kFiles / 2);
}

}  // namespace
}  // namespace isosplat::conformance
