#include <fmt/format.h>

#include "tests/conformance/sample.h"

namespace isosplat::conformance {

Sample make_raw(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const Number type = random.one_of({Number::u8, Number::i8, Number::u16, Number::i16, Number::u32,
                                     Number::i32, Number::f32, Number::f64});
  const bool floats = type == Number::f32 || type == Number::f64;
  choose_voxels(random, type, truth);
  const VoxelType types[] = {VoxelType::u8,  VoxelType::i8,  VoxelType::u16, VoxelType::i16,
                             VoxelType::u32, VoxelType::i32, VoxelType::u64, VoxelType::i64,
                             VoxelType::f32, VoxelType::f64};
  truth.steps = {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  const bool gzip = random.chance(25);
  import::ImportOptions& options = sample.options;
  std::string before;
  if (random.chance(40)) {
    options.spacing = Vec3d{1, 2, 3};
    truth.steps = {Vec3d{1, 0, 0}, Vec3d{0, 2, 0}, Vec3d{0, 0, 3}};
  }
  if (random.chance(30)) {
    sample.main = fmt::format("v_{}x{}x{}_{}.raw", truth.sizes[0], truth.sizes[1], truth.sizes[2],
                              voxel_type_name(types[static_cast<size_t>(type)]));
    sample.must_be_noted = true;
  } else {
    sample.main = "v.raw";
    options.dims = {truth.sizes[0], truth.sizes[1], truth.sizes[2]};
    options.type = types[static_cast<size_t>(type)];
    if (random.chance(80)) options.big_endian = random.chance(50);
    before = std::string(static_cast<size_t>(random.one_of({0, 0, 5})), 'h');
    options.skip_bytes = before.size();
  }
  sample.must_be_noted =
      sample.must_be_noted || !options.spacing || (!options.big_endian && bytes_of(type) > 1);
  if (gzip) sample.whole_at = {1};  // one byte does not show that the file was compressed
  const std::string bytes =
      before + binary_of(truth.values, type, options.big_endian.value_or(false));
  sample.files[sample.main] = gzip ? gzipped(bytes) : bytes;
  sample.text = sample.main + (floats ? " floats" : "") + (gzip ? " gzip" : "");
  return sample;
}

}  // namespace isosplat::conformance
