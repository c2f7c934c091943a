#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/conformance/sample.h"

// Written from the specification of MRC2014 (https://www.ccpem.ac.uk/mrc_format/mrc2014.php) and
// IMOD's description of its flags.
namespace isosplat::conformance {
namespace {

/// A header whose fields are set by their word, from 1 as in the specification.
class Header {
 public:
  explicit Header(bool big_endian) : bytes_(1024, '\0'), big_endian_(big_endian) {}

  template <class T>
  void set(size_t word, T value) {
    std::string raw;
    put(raw, value, big_endian_);
    bytes_.replace(4 * (word - 1), raw.size(), raw);
  }
  template <class T>
  void set_each(size_t word, const std::array<T, 3>& values) {
    for (size_t i = 0; i < 3; ++i) set(word + i, values[i]);
  }
  void set_text(size_t word, const std::string& text) {
    bytes_.replace(4 * (word - 1), text.size(), text);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
  bool big_endian_;
};

/// The 16-bit floating-point number of a whole multiple of 1/4 below 512.
uint16_t half_of(double value) {
  if (value == 0) return 0;
  int exponent = 0;
  const double fraction = std::frexp(std::abs(value), &exponent);  // from 0.5
  const auto bits =
      static_cast<uint16_t>((exponent + 14) << 10 | (static_cast<int>(fraction * 2048) & 1023));
  return static_cast<uint16_t>(bits | (value < 0 ? 0x8000 : 0));
}

/// Step vectors of the cell's axes in ångström: the first along x, the second in the plane of x
/// and y.
std::array<Vec3d, 3> cell_steps(const std::array<double, 3>& lengths,
                                const std::array<float, 3>& angles) {
  std::array<double, 3> c{};
  for (size_t i = 0; i < 3; ++i) {
    c[i] = angles[i] == 90 ? 0 : std::cos(static_cast<double>(angles[i]) * std::numbers::pi / 180);
  }
  const double sine = std::sqrt(1 - c[2] * c[2]), y = (c[0] - c[1] * c[2]) / sine;
  return {Vec3d{lengths[0], 0, 0}, Vec3d{c[2], sine, 0} * lengths[1],
          Vec3d{c[1], y, std::sqrt(1 - c[1] * c[1] - y * y)} * lengths[2]};
}

/// Sets the cell, the order of the axes and the position. Returns a description.
std::string set_geometry(Random& random, const std::array<int, 3>& sizes, Header& h,
                         Sample& sample) {
  std::array<int32_t, 3> axes{1, 2, 3};
  if (random.chance(50)) {
    for (int i = 2; i > 0; --i) std::swap(axes[i], axes[random.between(0, i)]);
  }
  h.set_each(17, axes);
  std::array<float, 3> angles{90, 90, 90};
  if (random.chance(20)) angles = {80, 95, 110};
  h.set_each(14, angles);
  std::array<int32_t, 3> sampling{};
  std::array<float, 3> cell{};
  std::array<double, 3> spacing{};
  for (size_t i = 0; i < 3; ++i) {
    sampling[axes[i] - 1] = sizes[i] + random.one_of({0, 0, 7});
  }
  for (size_t i = 0; i < 3; ++i) {
    spacing[i] = random.between(1, 40) * 0.25;
    cell[i] = static_cast<float>(spacing[i] * sampling[i]);
  }
  h.set_each(8, sampling);
  h.set_each(11, cell);
  const auto of_cell = cell_steps(spacing, angles);
  Truth& truth = sample.truth;
  for (size_t i = 0; i < 3; ++i) truth.steps[i] = of_cell[axes[i] - 1] * 1e-7;
  const bool has_origin = random.chance(40), has_start = random.chance(40);
  if (has_start) {
    std::array<int32_t, 3> start{};
    for (size_t i = 0; i < 3; ++i) {
      start[i] = random.between(-20, 20);
      truth.origin = truth.origin + truth.steps[i] * start[i];
    }
    h.set_each(5, start);
  }
  const int writer = random.between(0, 2);  // 0: not IMOD; 1: IMOD; 2: IMOD with MRC2014's sign
  if (writer > 0) {
    h.set(39, int32_t{1146047817});
    h.set(40, int32_t{writer == 2 ? 4 | 1 : 1});
  }
  if (has_origin) {
    const Vec3d place = choose_place(random) + Vec3d{0.5, 0, 0};
    h.set_each(50, std::array{static_cast<float>(place.x), static_cast<float>(place.y),
                              static_cast<float>(place.z)});
    truth.origin = place * (writer == 1 ? -1e-7 : 1e-7);
  }
  // Two positions can only be equal by accident here.
  sample.must_be_noted = has_origin && has_start;
  return fmt::format(" axes {}{}{}{}", axes[0], axes[1], axes[2],
                     angles[0] == 90 ? "" : ", sheared");
}

}  // namespace

Sample make_mrc(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const int mode = random.one_of({0, 1, 2, 6, 12});
  const Number types[] = {Number::i8, Number::i16, Number::f32};
  const Number type = mode == 6 ? Number::u16 : mode == 12 ? Number::f32 : types[mode];
  choose_voxels(random, type, truth);
  const int volumes = random.chance(20) ? random.between(2, 3) : 1;
  const int step = random.between(0, volumes - 1);
  if (volumes > 1) sample.options.time_step = step;
  const bool big_endian = random.chance(40);
  Header h(big_endian);
  h.set_each(1, std::array<int32_t, 3>{truth.sizes[0], truth.sizes[1], truth.sizes[2] * volumes});
  h.set(4, int32_t{mode});
  const std::string geometry = set_geometry(random, truth.sizes, h, sample);
  if (volumes > 1) {
    // A stack of volumes has whole cells, so its sections are z.
    h.set_each(17, std::array<int32_t, 3>{1, 2, 3});
    h.set_each(8, std::array<int32_t, 3>{truth.sizes[0], truth.sizes[1], truth.sizes[2]});
    h.set_each(11, std::array<float, 3>{static_cast<float>(2 * truth.sizes[0]),
                                        static_cast<float>(3 * truth.sizes[1]),
                                        static_cast<float>(4 * truth.sizes[2])});
    h.set_each(14, std::array<float, 3>{90, 90, 90});
    h.set_each(5, std::array<int32_t, 3>{});
    h.set_each(50, std::array<float, 3>{});
    truth.steps = {Vec3d{2e-7, 0, 0}, Vec3d{0, 3e-7, 0}, Vec3d{0, 0, 4e-7}};
    truth.origin = {0, 0, 0};
    sample.must_be_noted = false;
  }
  const auto [least, greatest] = std::minmax_element(truth.values.begin(), truth.values.end());
  h.set(20, static_cast<float>(*least));
  h.set(21, static_cast<float>(*greatest));
  h.set(23, int32_t{volumes > 1 ? 401 : 1});
  const int extended = random.one_of({0, 0, 80, 1024});
  h.set(24, int32_t{extended});
  h.set_text(27, extended > 0 ? "CCP4" : "");
  h.set(28, int32_t{random.one_of({0, 20140, 20141})});
  h.set_text(53, "MAP ");
  const bool old_stamp = random.chance(30);
  h.set_text(54, big_endian ? std::string("\x11\x11\0\0", 4)
                            : std::string(old_stamp ? "\x44\x41\0\0" : "\x44\x44\0\0", 4));
  h.set(56, int32_t{1});
  h.set_text(57, "made by a test");

  std::string voxels;
  for (int volume = 0; volume < volumes; ++volume) {
    for (const double value : truth.values) {
      const double stored = volume == step ? value : 3;
      if (mode == 12) {
        put(voxels, half_of(stored), big_endian);
      } else {
        put_number(voxels, type, stored, big_endian);
      }
    }
  }
  const std::string all = h.bytes() + std::string(static_cast<size_t>(extended), 'e') + voxels;
  const bool gzip = random.chance(30);
  sample.main = gzip ? "v.map.gz" : random.one_of({"v.mrc", "v.rec", "v.map"});
  sample.files[sample.main] = gzip ? gzipped(all) : all;
  sample.text = fmt::format("mode {}{}{}{}{}", mode, geometry, big_endian ? ", big-endian" : "",
                            volumes > 1 ? ", several volumes" : "", gzip ? ", gzip" : "");
  if (!gzip) {
    const std::string name = sample.main;
    const size_t low = big_endian ? 3 : 0;
    sample.damages.push_back([=](auto& files) {  // another number of columns
      char& columns = files[name][low];
      columns = columns == 2 ? 3 : 2;
    });
    sample.damages.push_back([=](auto& files) {  // a type of another size
      files[name][12 + low] = mode == 2 ? 1 : 2;
    });
    sample.damages.push_back([=](auto& files) {  // an axis twice
      files[name][64 + low] = files[name][68 + low];
    });
    sample.damages.push_back([=](auto& files) {  // an extended header that is not there
      files[name][92 + low] = static_cast<char>(files[name][92 + low] + 8);
    });
  }
  return sample;
}

}  // namespace isosplat::conformance
