#include <fmt/format.h>

#include "tests/conformance/sample.h"

// Written from FreeSurfer's description of the MGH format.
namespace isosplat::conformance {

Sample make_mgh(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const auto [type, code] = random.one_of<std::pair<Number, int>>(
      {{Number::u8, 0}, {Number::i32, 1}, {Number::f32, 3}, {Number::i16, 4}, {Number::u16, 10}});
  choose_voxels(random, type, truth);
  const bool is_packed = random.chance(40), has_geometry = random.chance(80);
  const int frames = random.one_of({1, 1, 3});
  const int frame = random.between(0, frames - 1);

  std::string file;
  put(file, int32_t{1}, true);
  for (const int size : truth.sizes) put(file, int32_t{size}, true);
  put(file, int32_t{frames}, true);
  put(file, int32_t{code}, true);
  put(file, int32_t{0}, true);
  put(file, static_cast<int16_t>(has_geometry), true);
  // In RAS. The position is that of the index (sizes / 2).
  truth.steps = choose_steps(random);
  Vec3d centre = choose_place(random);
  const auto put_float = [&](double value) { put(file, static_cast<float>(value), true); };
  for (const Vec3d step : truth.steps) put_float(length(step));
  for (const Vec3d step : truth.steps) {
    const Vec3d direction = step * (1 / length(step));
    for (const double part : {direction.x, direction.y, direction.z}) put_float(part);
  }
  for (const double part : {centre.x, centre.y, centre.z}) put_float(part);
  if (!has_geometry) {
    truth.steps = {Vec3d{-1, 0, 0}, Vec3d{0, 0, -1}, Vec3d{0, 1, 0}};
    centre = {0, 0, 0};
  }
  truth.origin = centre;
  for (size_t axis = 0; axis < 3; ++axis) {
    truth.origin = truth.origin - truth.steps[axis] * (truth.sizes[axis] / 2.0);
    truth.steps[axis] = with_signs(truth.steps[axis], {-1, -1, 1});
  }
  truth.origin = with_signs(truth.origin, {-1, -1, 1});
  sample.must_be_noted = !has_geometry;

  file.resize(284);
  for (int i = 0; i < frames; ++i) {
    const std::vector<double> other(truth.values.size(), i + 1);
    file += binary_of(i == frame ? truth.values : other, type, true);
  }
  if (frames > 1) {
    sample.options.time_step = frame;
    sample.needs_choice = true;
  }
  const bool has_end = random.chance(50);
  if (has_end) {  // repetition time, flip angle, echo time, inversion time
    for (const float value : {2300.0f, 0.15f, 2.98f, 900.0f}) put(file, value, true);
  }
  sample.may_be_longer = true;  // tags may follow
  sample.main = is_packed ? random.one_of({"v.mgz", "v.mgh.gz"}) : "v.mgh";
  sample.files[sample.main] = is_packed ? gzipped(file) : file;
  sample.text = fmt::format("type {}, {} frames{}{}", code, frames, is_packed ? ", packed" : "",
                            has_geometry ? "" : ", no geometry");
  if (!is_packed) {
    if (!has_end) sample.damages.push_back([](auto& files) { files["v.mgh"][7] += 1; });
    sample.damages.push_back([](auto& files) { files["v.mgh"][23] = 2; });
    sample.damages.push_back([](auto& files) { files["v.mgh"][16] = '\x80'; });
    sample.damages.push_back([](auto& files) { files["v.mgh"][3] = 2; });
  }
  return sample;
}

}  // namespace isosplat::conformance
