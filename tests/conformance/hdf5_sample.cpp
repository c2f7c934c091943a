#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/conformance/hdf5_writer.h"

// Written from the descriptions of the formats: the NetCDF User's Guide and CF, the dimension
// scales of HDF5, NeXus, VTKHDF, ITK's and ChimeraX's files, EMD, openPMD, Imaris 5.5,
// BigDataViewer and MATLAB.
namespace isosplat::conformance {
namespace {

/// A volume whose axes have letters.
struct Volume {
  std::string order;  ///< letters of the array's axes, the slowest first
  Number kind = Number::u8;
  std::array<double, 3> step{};   ///< of x, y, z; in the unit of the file
  std::array<double, 3> first{};  ///< position of the first voxel
  double unit = 1;                ///< mm

  Hdf5Node root;
  Sample sample;

  Truth& truth() { return sample.truth; }
  /// The size along the array's axis i, the slowest first.
  uint64_t size(size_t i) const { return static_cast<uint64_t>(sample.truth.sizes[2 - i]); }
  uint64_t size_of(char letter) const { return size(order.find(letter)); }
  std::vector<uint64_t> shape() const { return {size(0), size(1), size(2)}; }
  static size_t index(char letter) { return static_cast<size_t>(letter - 'x'); }
  std::vector<double> positions(char letter) const {
    std::vector<double> all;
    for (uint64_t i = 0; i < size_of(letter); ++i) {
      all.push_back(first[index(letter)] + static_cast<double>(i) * step[index(letter)]);
    }
    return all;
  }
  std::vector<double> each(const std::array<double, 3>& numbers) const {
    return {numbers[0], numbers[1], numbers[2]};
  }
};

void choose(Random& random, Volume& v, bool may_fall) {
  v.kind = static_cast<Number>(random.between(0, 9));
  choose_voxels(random, v.kind, v.truth());
  v.order = random.one_of({"zyx", "zyx", "xyz", "yxz", "zxy", "xzy", "yzx"});
  for (size_t i = 0; i < 3; ++i) {
    v.step[i] = random.between(1, 40) * 0.125 * (may_fall && random.chance(30) ? -1 : 1);
    v.first[i] = random.between(-40, 40) * 0.5;
  }
}

/// The dataset of the volume, in chunks or not.
Hdf5Node& add_array(Random& random, Volume& v, const std::string& path) {
  Hdf5Node& node = v.root.at(path);
  node.set_array(v.kind, v.shape(), v.truth().values, random.chance(30));
  if (random.chance(50)) {
    for (size_t i = 0; i < 3; ++i)
      node.chunk.push_back(static_cast<uint64_t>(random.between(2, 4)));
    node.is_compressed = random.chance(70);
  }
  return node;
}

/// Positions along the axes, without rotation.
void set_truth(Volume& v) {
  for (size_t i = 0; i < 3; ++i) {
    const size_t letter = Volume::index(v.order[2 - i]);
    Vec3d step{0, 0, 0};
    (letter == 0 ? step.x : letter == 1 ? step.y : step.z) = v.step[letter] * v.unit;
    v.truth().steps[i] = step;
  }
  v.truth().origin = Vec3d{v.first[0], v.first[1], v.first[2]} * v.unit;
}

void without_spacing(Volume& v) {
  v.step = {1, 1, 1};
  v.first = {0, 0, 0};
  v.unit = 1;
  v.sample.must_be_noted = true;
}

/// A unit of length, as a file names it.
std::string choose_unit(Random& random, Volume& v) {
  const std::string name = random.one_of({"mm", "um", "nm", "m", "cm", "micron", "micrometer"});
  v.unit = name == "mm" ? 1 : name == "nm" ? 1e-6 : name == "m" ? 1000 : name == "cm" ? 10 : 1e-3;
  return name;
}

// Each function writes the volume by one convention, and sets the expected result.

void plain(Random& random, Volume& v) {
  choose(random, v, false);
  v.order = "zyx";
  without_spacing(v);
  Hdf5Node& node = add_array(random, v, random.one_of({"volume", "a/b/c"}));
  if (random.chance(40)) {
    v.step = {0.5, 2, 3};
    v.unit = 1e-3;
    node.set_numbers("element_size_um", Number::f32, {3, 2, 0.5});
  }
}

/// Names of axes: those of netCDF's dimensions, or of positions.
std::string axis_name(Random& random, char letter) {
  const std::string x(1, letter);
  switch (random.between(0, 5)) {
    case 0:
      return "n" + x;
    case 1:
      return "pos_" + x;
    case 2:
      return letter == 'x' ? "lon" : letter == 'y' ? "lat" : "level";
    case 3:
      return letter == 'x' ? "column" : letter == 'y' ? "row" : "slice";
    default:
      return x;
  }
}

void set_values(Random& random, Volume& v, Hdf5Node& node) {
  auto& values = v.truth().values;
  const std::vector<double> stored = values;
  const double missing = stored[static_cast<size_t>(random.between(0, 3))];
  double slope = 1, intercept = 0;
  if (random.chance(30)) {
    slope = random.one_of({0.5, -2.0, 0.25});
    intercept = random.one_of({0.0, 10.0});
    node.set_numbers("scale_factor", Number::f64, {slope}, true);
    node.set_numbers("add_offset", Number::f64, {intercept}, true);
  }
  const bool has_missing = random.chance(50), has_range = random.chance(30);
  const double least = *std::min_element(stored.begin(), stored.end()) + 3;
  if (has_missing) {
    const char* name = random.one_of({"missing_value", "_FillValue"});
    node.set_numbers(name, v.kind, {missing}, random.chance(50));
    v.sample.must_be_noted = true;
  }
  if (has_range) {
    node.set_numbers("valid_min", v.kind, {least}, true);
    v.sample.must_be_noted = true;
  }
  for (size_t i = 0; i < values.size(); ++i) {
    const bool is_absent =
        (has_missing && stored[i] == missing) || (has_range && stored[i] < least);
    values[i] =
        is_absent ? std::numeric_limits<double>::quiet_NaN() : intercept + slope * stored[i];
  }
}

void netcdf(Random& random, Volume& v) {
  choose(random, v, true);
  const bool has_positions = random.chance(70);
  const std::string unit = choose_unit(random, v);
  std::vector<const Hdf5Node*> scales;
  for (const char letter : v.order) {
    Hdf5Node& scale = v.root.at(axis_name(random, letter));
    if (has_positions) {
      scale.set_array(random.chance(50) ? Number::f64 : Number::f32, {v.size_of(letter)},
                      v.positions(letter));
      scale.set_text("NAME", scale.name);
      scale.set_text("units", unit);
    } else {
      scale.set_array(Number::f32, {v.size_of(letter)}, std::vector<double>(v.size_of(letter)),
                      true);
      scale.set_text("NAME",
                     fmt::format("This is a netCDF dimension but not a netCDF variable.{:10}",
                                 v.size_of(letter)));
    }
    scale.set_text("CLASS", "DIMENSION_SCALE");
    scales.push_back(&scale);
  }
  if (!has_positions) without_spacing(v);
  Hdf5Node& node = add_array(random, v, random.chance(30) ? "inner/density" : "density");
  node.set_references("DIMENSION_LIST", scales);
  set_values(random, v, node);
}

void unsigned_numbers(Random& random, Volume& v) {
  choose(random, v, false);
  v.kind = random.one_of({Number::i8, Number::i16, Number::i32});
  v.order = "zyx";
  without_spacing(v);
  const double range = std::exp2(8.0 * static_cast<double>(bytes_of(v.kind)));
  std::vector<double> stored;
  for (double& value : v.truth().values) {
    value = std::floor(random.real(0, range));
    stored.push_back(value < range / 2 ? value : value - range);
  }
  Hdf5Node& node = v.root.at("density");
  node.set_array(v.kind, v.shape(), stored);
  node.set_text("_Unsigned", "true");
}

void nexus(Random& random, Volume& v) {
  choose(random, v, true);
  const std::string unit = choose_unit(random, v);
  Hdf5Node& group = v.root.at("entry/data");
  std::string joined;
  for (const char letter : v.order) {
    Hdf5Node& node = group.at(axis_name(random, letter));
    node.set_array(Number::f64, {v.size_of(letter)}, v.positions(letter));
    node.set_text("units", unit);
    joined += (joined.empty() ? "" : ":") + node.name;
  }
  Hdf5Node& node = add_array(random, v, "entry/data/counts");
  node.set_numbers("signal", Number::i32, {1}, true);
  node.set_text("axes", joined);
}

/// Vectors of length 1 along the array's axes, the fastest first.
std::array<Vec3d, 3> choose_directions(Random& random) {
  auto steps = choose_steps(random);
  for (Vec3d& step : steps) step = step * (1 / length(step));
  return steps;
}

void vtk(Random& random, Volume& v) {
  choose(random, v, false);
  v.order = "zyx";
  const bool has_cells = random.chance(30);
  const auto directions = random.chance(60)
                              ? choose_directions(random)
                              : std::array{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  Hdf5Node& group = v.root.at("VTKHDF");
  group.set_numbers("Version", Number::i64, {1, 0});
  group.set_text("Type", "ImageData");
  std::vector<double> extent;
  v.truth().origin = {v.first[0], v.first[1], v.first[2]};
  for (size_t i = 0; i < 3; ++i) {
    const int begin = random.one_of({0, 0, -3, 5});
    extent.push_back(begin);
    extent.push_back(begin + v.truth().sizes[i] - (has_cells ? 0 : 1));
    v.truth().steps[i] = directions[i] * v.step[i];
    v.truth().origin = v.truth().origin + v.truth().steps[i] * (begin + (has_cells ? 0.5 : 0));
  }
  group.set_numbers("WholeExtent", Number::i32, extent);
  group.set_numbers("Origin", Number::f64, v.each(v.first));
  group.set_numbers("Spacing", Number::f64, v.each(v.step));
  std::vector<double> matrix;
  for (size_t row = 0; row < 3; ++row) {
    for (const Vec3d& d : directions) matrix.push_back(row == 0 ? d.x : row == 1 ? d.y : d.z);
  }
  group.set_numbers("Direction", Number::f64, matrix);
  add_array(random, v, has_cells ? "VTKHDF/CellData/density" : "VTKHDF/PointData/density");
  v.sample.must_be_noted = has_cells;
  v.unit = 0;  // the truth is set
}

void itk(Random& random, Volume& v) {
  choose(random, v, false);
  v.order = "zyx";
  const auto directions = choose_directions(random);
  Hdf5Node& group = v.root.at("ITKImage/0");
  std::vector<double> rows;
  for (size_t i = 0; i < 3; ++i) {
    v.truth().steps[i] = directions[i] * v.step[i];
    for (const double number : {directions[i].x, directions[i].y, directions[i].z}) {
      rows.push_back(number);
    }
  }
  v.truth().origin = {v.first[0], v.first[1], v.first[2]};
  group.at("Directions").set_array(Number::f64, {3, 3}, rows);
  group.at("Origin").set_array(Number::f64, {3}, v.each(v.first));
  group.at("Spacing").set_array(Number::f64, {3}, v.each(v.step));
  add_array(random, v, "ITKImage/0/VoxelData");
  v.unit = 0;
}

void chimera(Random& random, Volume& v) {
  choose(random, v, false);
  v.order = "zyx";
  v.unit = 1e-7;
  Hdf5Node& group = v.root.at("Chimera/image1");
  group.set_numbers("step", Number::f32, v.each(v.step));
  group.set_numbers("origin", Number::f32, v.each(v.first));
  add_array(random, v, "Chimera/image1/data_zyx");
  Hdf5Node& coarse = group.at("data_zyx_2");
  coarse.set_array(Number::u8, {2, 2, 2}, std::vector<double>(8, 1));
  coarse.set_numbers("subsample_spacing", Number::i32, {2, 2, 2});
  v.sample.must_be_noted = true;
}

void emd(Random& random, Volume& v) {
  choose(random, v, false);
  v.unit = 1e-6;
  const bool is_new = random.chance(50);
  Hdf5Node& group = v.root.at("data/volume");
  if (is_new) group.set_text("emd_group_type", "array");
  if (!is_new) group.set_numbers("emd_group_type", Number::i32, {1}, true);
  for (size_t i = 0; i < 3; ++i) {
    Hdf5Node& dim = group.at(fmt::format("dim{}", is_new ? i : i + 1));
    auto positions = v.positions(v.order[i]);
    if (is_new) positions.resize(2);
    dim.set_array(Number::f64, {positions.size()}, positions);
    dim.set_text("name", std::string(1, v.order[i]));
    dim.set_text("units", is_new ? "nm" : "[n_m]");
  }
  add_array(random, v, "data/volume/data");
}

void open_pmd(Random& random, Volume& v) {
  choose(random, v, false);
  v.unit = 1;
  Hdf5Node& node = add_array(random, v, "data/100/fields/rho");
  std::vector<double> steps, firsts;
  for (const char letter : v.order) {
    steps.push_back(v.step[Volume::index(letter)]);
    firsts.push_back(v.first[Volume::index(letter)]);
  }
  // Three texts of one character.
  Hdf5Node::Attribute labels{"axisLabels", std::string("\x13\0\0\0\1\0\0\0", 8), {3}, v.order, {}};
  node.attributes.push_back(labels);
  node.set_numbers("gridSpacing", Number::f64, steps);
  node.set_numbers("gridGlobalOffset", Number::f64, firsts);
  node.set_numbers("gridUnitSI", Number::f64, {1e-3}, true);
}

/// Imaris writes each character of a text as an element.
void set_letters(Hdf5Node& node, const std::string& name, const std::string& text) {
  node.attributes.push_back({name, std::string("\x13\0\0\0\1\0\0\0", 8), {text.size()}, text, {}});
}

void imaris(Random& random, Volume& v) {
  choose(random, v, false);
  v.kind = random.one_of({Number::u8, Number::u16, Number::f32});
  for (double& value : v.truth().values) value = std::fmod(std::floor(std::abs(value)), 251);
  v.order = "zyx";
  v.unit = 1e-3;
  const bool has_old_sizes = random.chance(30);
  Hdf5Node& image = v.root.at("DataSetInfo/Image");
  const int channels = random.between(1, 2), times = random.between(1, 2);
  const int channel = random.between(0, channels - 1), time = random.between(0, times - 1);
  if (channels > 1) v.sample.options.channel = channel;
  if (times > 1) v.sample.options.time_step = time;
  std::vector<uint64_t> padded;
  for (size_t i = 0; i < 3; ++i) padded.push_back((v.size(i) + 7) / 8 * 8);
  for (size_t i = 0; i < 3; ++i) {
    const std::string axis(1, "XYZ"[i]);
    set_letters(image, axis, std::to_string(v.truth().sizes[i]));
    const double low = v.first[i] - v.step[i] / 2;
    set_letters(image, fmt::format("ExtMin{}", i), text_of(low));
    set_letters(image, fmt::format("ExtMax{}", i), text_of(low + v.step[i] * v.truth().sizes[i]));
  }
  set_letters(image, "Unit", "um");
  for (int level = 0; level < 2; ++level) {
    for (int t = 0; t < times; ++t) {
      for (int c = 0; c < channels; ++c) {
        Hdf5Node& group = v.root.at(
            fmt::format("DataSet/ResolutionLevel {}/TimePoint {}/Channel {}", level, t, c));
        std::vector<double> values(padded[0] * padded[1] * padded[2]);
        const bool is_it = level == 0 && t == time && c == channel;
        for (size_t i = 0; i < v.truth().values.size() && is_it; ++i) {
          const size_t x = i % v.size(2), y = i / v.size(2) % v.size(1),
                       z = i / v.size(2) / v.size(1);
          values[(z * padded[1] + y) * padded[2] + x] = v.truth().values[i];
        }
        for (size_t i = 0; i < 3 && !has_old_sizes; ++i) {
          set_letters(group, std::string("ImageSize") + "XYZ"[i],
                      std::to_string(v.truth().sizes[i]));
        }
        Hdf5Node& data = group.at("Data");
        data.set_array(v.kind, padded, values);
        data.chunk = {4, 8, 8};
        data.is_compressed = true;
      }
    }
  }
}

void big_data_viewer(Random& random, Volume& v) {
  choose(random, v, false);
  v.order = "zyx";
  without_spacing(v);
  std::vector<double> stored;
  for (double& value : v.truth().values) {
    value = random.between(0, 65535);
    stored.push_back(value < 32768 ? value : value - 65536);
  }
  const int setups = random.between(1, 2), setup = random.between(0, setups - 1);
  if (setups > 1) v.sample.options.channel = setup;
  for (int s = 0; s < setups; ++s) {
    v.root.at(fmt::format("s{:02}/resolutions", s))
        .set_array(Number::f64, {2, 3}, {1, 1, 1, 2, 2, 2});
    Hdf5Node& cells = v.root.at(fmt::format("t00000/s{:02}/0/cells", s));
    cells.set_array(Number::i16, v.shape(),
                    s == setup ? stored : std::vector<double>(stored.size()));
    cells.chunk = {4, 4, 4};
    cells.is_compressed = true;
    v.root.at(fmt::format("t00000/s{:02}/1/cells", s))
        .set_array(Number::i16, {2, 2, 2}, std::vector<double>(8));
  }
}

void matlab(Random& random, Volume& v) {
  choose(random, v, false);
  v.order = "zxy";
  without_spacing(v);
  add_array(random, v, "V").set_text("MATLAB_class", "double");
}

using Convention = void (*)(Random&, Volume&);
struct Named {
  const char* name;
  Convention write;
};
constexpr Named kConventions[] = {
    {"plain", plain},   {"netCDF", netcdf},
    {"netCDF", netcdf}, {"unsigned netCDF", unsigned_numbers},
    {"NeXus", nexus},   {"VTKHDF", vtk},
    {"ITK", itk},       {"Chimera", chimera},
    {"EMD", emd},       {"openPMD", open_pmd},
    {"Imaris", imaris}, {"BigDataViewer", big_data_viewer},
    {"MATLAB", matlab},
};

}  // namespace

Sample make_hdf5(Random& random) {
  Volume v;
  const Named& convention = kConventions[random.between(0, std::size(kConventions) - 1)];
  convention.write(random, v);
  if (v.unit != 0) set_truth(v);
  v.sample.main = "v.h5";
  v.sample.files["v.h5"] = hdf5_bytes(v.root);
  v.sample.may_be_longer = true;  // the superblock says where the file ends
  v.sample.text = fmt::format("{}, axes {}", convention.name, v.order);
  return std::move(v.sample);
}

}  // namespace isosplat::conformance
