#include <fmt/format.h>

#include "tests/conformance/sample.h"

// Written from "A simple file format for NumPy arrays" (NEP 1) and numpy.lib.format.
namespace isosplat::conformance {
namespace {

constexpr const char* kKinds[] = {"u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"};

/// The dictionary, as numpy.save writes it or with another order of its keys.
std::string dictionary_of(Random& random, const std::string& type, bool fortran_order,
                          const std::array<int, 3>& shape, int before) {
  std::string sizes;
  for (int i = 0; i < before; ++i) sizes += "1, ";
  sizes += fmt::format("{}, {}, {}", shape[0], shape[1], shape[2]);
  std::vector<std::string> items{
      fmt::format("'descr': '{}'", type),
      fmt::format("'fortran_order': {}", fortran_order ? "True" : "False"),
      fmt::format("'shape': ({})", sizes)};
  if (random.chance(20)) std::swap(items[0], items[2]);
  return fmt::format("{{{}, {}, {}, }}", items[0], items[1], items[2]);
}

}  // namespace

Sample make_npy(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const auto type = static_cast<Number>(random.between(0, 9));
  choose_voxels(random, type, truth);
  const bool big_endian = random.chance(40), fortran_order = random.chance(40);
  const bool is_byte = bytes_of(type) == 1;
  const std::string name = (is_byte      ? "|"
                            : big_endian ? ">"
                                         : "<") +
                           std::string(kKinds[static_cast<size_t>(type)]);
  // In Fortran's order, z is the fastest axis of the file, and the first one of the shape.
  const auto& [first, second, third] = truth.sizes;
  const std::array<int, 3> shape =
      fortran_order ? truth.sizes : std::array<int, 3>{third, second, first};
  const std::string dictionary =
      dictionary_of(random, name, fortran_order, shape, random.one_of({0, 0, 0, 1, 2}));
  const Vec3d spacing = random.chance(50) ? Vec3d{0.5, 2, 3} : Vec3d{1, 1, 1};
  if (spacing.y != 1) sample.options.spacing = spacing;
  const Vec3d x{spacing.x, 0, 0}, y{0, spacing.y, 0}, z{0, 0, spacing.z};
  truth.steps = fortran_order ? std::array{z, y, x} : std::array{x, y, z};
  sample.must_be_noted = true;

  const int version = random.between(1, 3);
  const size_t begin = version == 1 ? 10 : 12;
  // The voxels begin at a multiple of 64, or of 16 in files of NumPy before 1.14.
  const size_t unit = random.one_of({64, 16});
  const size_t voxels = (begin + dictionary.size() + 1 + unit - 1) / unit * unit;
  const std::string padding(voxels - begin - dictionary.size() - 1, ' ');
  const size_t bytes = voxels - begin;
  std::string file = "\x93NUMPY";
  file += static_cast<char>(version);
  file += '\0';
  if (version == 1) put(file, static_cast<uint16_t>(bytes), false);
  if (version > 1) put(file, static_cast<uint32_t>(bytes), false);
  file += dictionary + padding + "\n" + binary_of(truth.values, type, !is_byte && big_endian);
  sample.main = "v.npy";
  sample.files["v.npy"] = file;
  sample.text =
      fmt::format("version {} of {}{}", version, name, fortran_order ? ", Fortran's order" : "");
  const auto replace = [&](const std::string& from, const std::string& to) {
    sample.damages.push_back([=](auto& files) {
      std::string& content = files["v.npy"];
      content.replace(content.find(from), from.size(), to);
    });
  };
  replace("'shape': (", "'shape': (2, ");
  replace("'descr'", "'order'");
  replace(name, is_byte ? "<i2" : "|u1");
  replace("rder': ", "rder': not ");
  return sample;
}

}  // namespace isosplat::conformance
