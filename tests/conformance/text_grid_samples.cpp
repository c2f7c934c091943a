#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/conformance/sample.h"

// Formats of chemistry whose values are text. Written from Gaussian's description of cubegen,
// VASP's wiki (CHGCAR, POSCAR), XCrySDen's description of XSF, and OpenDX's user guide (native
// files).
namespace isosplat::conformance {
namespace {

constexpr double kAngstrom = 1e-7, kBohr = 0.529177210903e-7;

std::string numbers(Vec3d v) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", v.x, v.y, v.z);
}

std::array<Vec3d, 3> scaled(std::array<Vec3d, 3> steps, double by) {
  for (Vec3d& step : steps) step = step * by;
  return steps;
}

/// Values of `count` volumes, those of a voxel together.
std::vector<double> interleaved(const std::vector<double>& values, int count, int at) {
  std::vector<double> out;
  for (const double value : values) {
    for (int i = 0; i < count; ++i) out.push_back(i == at ? value : i + 1);
  }
  return out;
}

std::string atoms(Random& random, int count, int fields) {
  std::string out;
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < fields; ++k) out += fmt::format(" {:.6f}", random.real(0, 9));
    out += "\n";
  }
  return out;
}

}  // namespace

Sample make_cube(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  choose_voxels(random, Number::f32, truth);
  const bool in_angstrom = random.chance(40);
  const double unit = in_angstrom ? kAngstrom : kBohr;
  const auto steps = choose_steps(random, true);
  const Vec3d origin = choose_place(random);
  truth.steps = scaled(steps, unit);
  truth.origin = origin * unit;
  // The fastest axis is written last.
  const int count = random.between(1, 3), orbitals = random.one_of({0, 0, 1, 3});
  const int values = orbitals > 0 ? orbitals : random.one_of({1, 1, 2});
  const int at = random.between(0, values - 1);
  std::string file = fmt::format("a molecule\n{}\n", random.one_of({"density", "1 2 3 4", ""}));
  file += fmt::format(
      "{} {}{}\n", orbitals > 0 ? -count : count, numbers(origin),
      orbitals == 0 && (values > 1 || random.chance(30)) ? fmt::format(" {}", values) : "");
  for (const size_t axis : {2, 1, 0}) {
    file += fmt::format("{} {}\n", in_angstrom ? -truth.sizes[axis] : truth.sizes[axis],
                        numbers(steps[axis]));
  }
  file += atoms(random, count, 5);
  if (orbitals > 0) {
    file += fmt::format(" {}", orbitals);
    for (int i = 0; i < orbitals; ++i) file += fmt::format("{} {}", i == 1 ? "\n" : "", 7 + i);
    file += "\n";
  }
  file += text_of(interleaved(truth.values, values, at), random);
  if (values > 1) {
    sample.options.channel = at;
    sample.needs_choice = true;
  }
  sample.main = random.one_of({"v.cube", "v.cub", "v.dat"});
  sample.files[sample.main] = file;
  sample.text = fmt::format("{} values, {} orbitals", values, orbitals);
  sample.damages.push_back([name = sample.main](auto& files) { files[name] += "1.5\n"; });
  sample.damages.push_back([name = sample.main](auto& files) {
    std::string& text = files[name];
    text.insert(text.find_last_of(" \n", text.size() - 3) + 1, 1, 'x');
  });
  return sample;
}

Sample make_vasp(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  choose_voxels(random, Number::f32, truth);
  std::array<Vec3d, 3> cell{};
  const auto steps = choose_steps(random, true);
  for (size_t axis = 0; axis < 3; ++axis) cell[axis] = steps[axis] * truth.sizes[axis];
  const double volume = std::abs(dot(cell[0], cross(cell[1], cell[2])));
  truth.steps = scaled(steps, kAngstrom);
  const bool is_potential = random.chance(30), has_spin = random.chance(40);
  const double factor = random.one_of({1.0, 2.5, 0.0});
  std::string file = "a crystal\n";
  file += factor > 0 ? fmt::format("  {:.17g}\n", factor) : fmt::format("{:.17g}\n", -volume);
  for (const Vec3d axis : cell) {
    file += numbers(axis * (factor > 0 ? 1 / factor : 3)) + "\n";
  }
  if (random.chance(70)) file += "  Si  O\n";
  file += "  1  2\n";
  if (random.chance(30)) file += "Selective dynamics\n";
  file += random.one_of({"Direct\n", "Cartesian\n"});
  file += atoms(random, 3, 3) + "\n";
  const std::string sizes =
      fmt::format("  {} {} {}\n", truth.sizes[0], truth.sizes[1], truth.sizes[2]);
  const int at = has_spin ? random.between(0, 1) : 0;
  for (int block = 0; block < (has_spin ? 2 : 1); ++block) {
    std::vector<double> values = truth.values;
    if (block != at) std::fill(values.begin(), values.end(), 3);
    if (!is_potential) {
      for (double& value : values) value *= volume;
    }
    if (block > 0) sample.whole_at.insert(static_cast<int>(file.size()));
    file += sizes + text_of(values, random);
    if (random.chance(50)) file += "augmentation occupancies 1 4\n 0.1 0.2 0.3 0.4\n";
  }
  // A file that ends after a volume is whole; so is one with other numbers after it.
  sample.may_be_longer = true;
  if (has_spin) {
    sample.options.channel = at;
    sample.open_ended.insert(is_potential ? "LOCPOT" : "CHGCAR");
  }
  sample.must_be_noted = !is_potential;
  sample.main = is_potential ? "LOCPOT" : "CHGCAR";
  sample.files[sample.main] = file;
  sample.text = fmt::format("factor {}{}", factor, has_spin ? ", spin" : "");
  sample.damages.push_back([name = sample.main, sizes](auto& files) {
    std::string& text = files[name];
    text.replace(text.find(sizes), sizes.size(), "  9 9 9\n");
  });
  return sample;
}

Sample make_xsf(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  choose_voxels(random, Number::f32, truth);
  const auto steps = choose_steps(random, true);
  const Vec3d origin = choose_place(random);
  truth.steps = scaled(steps, kAngstrom);
  truth.origin = origin * kAngstrom;
  std::string file = random.chance(50) ? "# a comment\n\n" : "";
  if (random.chance(60)) {
    file += "CRYSTAL\nPRIMVEC\n 9 0 0\n 0 9 0\n 0 0 9\nPRIMCOORD\n 1 1\n 6 0 0 0\n";
  }
  const int grids = random.one_of({1, 1, 2}), at = random.between(0, grids - 1);
  file += "BEGIN_BLOCK_DATAGRID_3D\n a_name\n";
  for (int i = 0; i < grids; ++i) {
    file += fmt::format(" {}_3D_grid{}\n", random.one_of({"BEGIN_DATAGRID", "DATAGRID"}), i);
    file += fmt::format("  {} {} {}\n  {}\n", truth.sizes[0], truth.sizes[1], truth.sizes[2],
                        numbers(origin));
    for (size_t axis = 0; axis < 3; ++axis) {
      file += "  " + numbers(steps[axis] * (truth.sizes[axis] - 1)) + "\n";
    }
    file += text_of(i == at ? truth.values : std::vector<double>(truth.values.size(), 5), random);
    file += " END_DATAGRID_3D\n";
  }
  file += "END_BLOCK_DATAGRID_3D\n";
  if (grids > 1) {
    sample.options.channel = at;
    sample.needs_choice = true;
  }
  sample.may_be_longer = true;
  sample.main = "v.xsf";
  sample.files["v.xsf"] = file;
  sample.text = fmt::format("{} datagrids", grids);
  sample.damages.push_back([](auto& files) {
    std::string& text = files["v.xsf"];
    text.insert(text.find(" END_DATAGRID"), "1.5\n");
  });
  return sample;
}

Sample make_dx(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  choose_voxels(random, Number::f32, truth);
  const auto steps = choose_steps(random, true);
  const Vec3d origin = choose_place(random);
  truth.steps = scaled(steps, kAngstrom);
  truth.origin = origin * kAngstrom;
  const std::string sizes = fmt::format("{} {} {}", truth.sizes[2], truth.sizes[1], truth.sizes[0]);
  std::string file = random.chance(70) ? "# Data from APBS\n#\n" : "";
  file += "object 1 class gridpositions counts " + sizes + "\norigin " + numbers(origin) + "\n";
  for (const size_t axis : {2, 1, 0}) file += "delta " + numbers(steps[axis]) + "\n";
  if (random.chance(80)) file += "object 2 class gridconnections counts " + sizes + "\n";
  file += fmt::format("object 3 class array type {} {} items {} data follows\n",
                      random.one_of({"double", "float"}),
                      random.one_of({"rank 0", "rank 1 shape 1"}), truth.values.size());
  file += text_of(truth.values, random);
  if (random.chance(70)) {
    file +=
        "attribute \"dep\" string \"positions\"\nobject \"a\" class field\n"
        "component \"positions\" value 1\ncomponent \"data\" value 3\n";
  }
  sample.must_be_noted = true;
  sample.may_be_longer = true;
  sample.main = "v.dx";
  sample.files["v.dx"] = file;
  sample.text = "a grid";
  sample.damages.push_back([sizes](auto& files) {
    std::string& text = files["v.dx"];
    text[text.find(sizes)] = '9';
  });
  sample.damages.push_back([](auto& files) {
    std::string& text = files["v.dx"];
    text.insert(text.find("follows\n") + 8, "1.5 ");
  });
  return sample;
}

}  // namespace isosplat::conformance
