#include <fmt/format.h>

#include <limits>

#include "tests/conformance/netcdf_writer.h"

// Written from CF.
namespace isosplat::conformance {
Sample make_netcdf(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const int version = random.one_of({1, 2, 5});
  const Number type =
      version == 5
          ? static_cast<Number>(random.between(0, 9))
          : random.one_of({Number::i8, Number::i16, Number::i32, Number::f32, Number::f64});
  choose_voxels(random, type, truth);
  NetcdfWriter file(version);

  // Axes, the slowest first. Records, of times or of slices, are along the first one.
  const std::string order = random.one_of({"zyx", "zyx", "xyz", "yxz", "zxy"});
  const bool has_times = random.chance(40), has_records = random.chance(60);
  const int times = random.between(2, 3), time = random.between(0, times - 1);
  std::vector<int> shape;
  if (has_times) {
    shape.push_back(static_cast<int>(file.axes.size()));
    file.axes.push_back({random.one_of({"time", "t"}), times, has_records});
  }
  for (size_t i = 0; i < 3; ++i) {
    const bool is_record = has_records && !has_times && i == 0;
    shape.push_back(static_cast<int>(file.axes.size()));
    file.axes.push_back({std::string(1, order[i]), truth.sizes[2 - i], is_record});
  }
  if (has_records) file.records = file.axes[size_t(shape[0])].size;
  file.is_streamed = has_records && random.chance(20);

  // Positions, in a unit of length.
  const bool has_positions = random.chance(70);
  const std::string unit = random.one_of({"mm", "m", "micrometer", "km"});
  const double millimetres = unit == "mm" ? 1 : unit == "m" ? 1e3 : unit == "km" ? 1e6 : 1e-3;
  const bool falls = random.chance(30);
  std::array<double, 3> origin{};
  for (size_t i = 0; i < 3; ++i) {
    const size_t letter = static_cast<size_t>(order[i] - 'x');
    double step = 1, first = 0, sign = 1;
    if (has_positions) {
      step = random.between(1, 40) * 0.125 * (falls ? -1 : 1);
      first = random.between(-40, 40) * 0.5;
      const int axis = shape[i + (has_times ? 1 : 0)];
      NetcdfArray positions{
          file.axes[size_t(axis)].name, {axis}, random.one_of({Number::f32, Number::f64}), {}};
      for (int k = 0; k < truth.sizes[2 - i]; ++k) positions.values.push_back(first + k * step);
      positions.attributes.push_back({"units", unit});
      if (random.chance(50))
        positions.attributes.push_back({"axis", std::string(1, char(order[i] - 32))});
      if (order[i] == 'z' && random.chance(30)) {
        positions.attributes.push_back({"positive", "down"});
        sample.must_be_noted = true;
        sign = -1;
      }
      file.arrays.push_back(std::move(positions));
    }
    const double scale = has_positions ? millimetres : 1;
    Vec3d vector{0, 0, 0};
    (letter == 0 ? vector.x : letter == 1 ? vector.y : vector.z) = sign * step * scale;
    truth.steps[2 - i] = vector;
    origin[letter] = sign * first * scale;
  }
  truth.origin = {origin[0], origin[1], origin[2]};
  if (!has_positions) sample.must_be_noted = true;
  if (has_times && random.chance(70)) {
    NetcdfArray all{file.axes[0].name, {0}, Number::f64, {}};
    for (int i = 0; i < times; ++i) all.values.push_back(0.5 * i);
    all.attributes.push_back({"units", "hours since 1900-01-01"});
    file.arrays.push_back(std::move(all));
  }
  // Characters, and an array with another number of bytes in each record.
  if (random.chance(40)) file.arrays.push_back({"names", {shape[0], shape[2]}, std::nullopt, {}});
  if (random.chance(40)) {
    std::vector<double> values(size_t(file.axes[size_t(shape[0])].size), 7);
    file.arrays.push_back({"other", {shape[0]}, Number::i16, values});
  }

  NetcdfArray data{"data", shape, type, {}};
  for (int i = 0; i < (has_times ? times : 1); ++i) {
    for (const double value : truth.values) {
      data.values.push_back(!has_times || i == time ? value : i + 1);
    }
  }
  const std::vector<double> stored = truth.values;
  double slope = 1, intercept = 0;
  if (random.chance(30)) {
    slope = random.one_of({0.5, -2.0, 0.25});
    intercept = random.one_of({0.0, 10.0});
    data.attributes.push_back({"scale_factor", "", Number::f64, {slope}});
    data.attributes.push_back({"add_offset", "", Number::f32, {intercept}});
  }
  for (double& value : truth.values) value = slope * value + intercept;
  if (random.chance(40)) {
    const double missing = stored[size_t(random.between(0, 3))];
    data.attributes.push_back(
        {random.one_of({"_FillValue", "missing_value"}), "", type, {missing}});
    for (size_t i = 0; i < stored.size(); ++i) {
      if (stored[i] == missing) truth.values[i] = std::numeric_limits<double>::quiet_NaN();
    }
    sample.must_be_noted = true;
  }
  data.attributes.push_back({"long_name", "the data"});
  file.arrays.insert(file.arrays.begin() + random.between(0, static_cast<int>(file.arrays.size())),
                     data);

  if (has_times) {
    sample.options.time_step = time;
    sample.needs_choice = true;
  }
  if (random.chance(30)) sample.options.dataset = "data";
  sample.main = random.one_of({"v.nc", "v.cdf", "v"});
  sample.files[sample.main] = file.bytes();
  sample.may_be_longer = true;
  // The last bytes may be padding, or belong to another array.
  sample.open_ended.insert(sample.main);
  sample.text =
      fmt::format("CDF-{}, axes {}, {}{}{}", version, order, has_times ? "times, " : "",
                  has_records ? "records" : "no records", file.is_streamed ? ", streamed" : "");
  const std::string main = sample.main;
  sample.damages.push_back([main](auto& files) { files[main][3] = '\x07'; });
  sample.damages.push_back([main](auto& files) { files[main].resize(60); });
  sample.damages.push_back([main](auto& files) {
    files[main].resize(files[main].find("the data"));  // in the header
  });
  return sample;
}

}  // namespace isosplat::conformance
