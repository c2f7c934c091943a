#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/conformance/sample.h"

// Written from nifti1.h and nifti2.h (https://nifti.nimh.nih.gov).
namespace isosplat::conformance {
namespace {

int16_t datatype_code(Number type) {
  constexpr int16_t kDatatypeCodes[] = {2, 256, 512, 4, 768, 8, 1280, 1024, 16, 64};
  return kDatatypeCodes[static_cast<size_t>(type)];
}

/// A header of NIfTI-1 or NIfTI-2, whose fields are set by their offsets.
class Header {
 public:
  Header(bool is_two, bool big_endian)
      : is_two_(is_two), bytes_(is_two ? 540 : 348, '\0'), big_endian_(big_endian) {
    set(0, static_cast<int32_t>(bytes_.size()));
  }

  template <class T>
  void set(size_t offset, T value) {
    std::string raw;
    put(raw, value, big_endian_);
    std::copy(raw.begin(), raw.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  void set_text(size_t offset, const std::string& text) {
    bytes_.replace(offset, text.size(), text);
  }

  /// Fields at offset `one` in NIfTI-1 and at `two` in NIfTI-2: f32 or f64, i16 or i32, i16 or i64.
  void set_real(size_t one, size_t two, double value) {
    is_two_ ? set(two, value) : set(one, static_cast<float>(value));
  }
  void set_code(size_t one, size_t two, int value) {
    is_two_ ? set(two, static_cast<int32_t>(value)) : set(one, static_cast<int16_t>(value));
  }
  void set_size(size_t one, size_t two, int value) {
    is_two_ ? set(two, static_cast<int64_t>(value)) : set(one, static_cast<int16_t>(value));
  }

  bool is_two() const { return is_two_; }
  const std::string& bytes() const { return bytes_; }

 private:
  bool is_two_;
  std::string bytes_;
  bool big_endian_;
};

/// The quaternion (b, c, d) with a ≥ 0 of the rotation with these columns.
std::array<double, 3> quaternion_of(const std::array<Vec3d, 3>& c) {
  const double xx = c[0].x, yy = c[1].y, zz = c[2].z;
  const double trace = xx + yy + zz + 1;
  double a, b, cc, d;
  if (trace > 0.5) {
    a = 0.5 * std::sqrt(trace);
    b = 0.25 * (c[1].z - c[2].y) / a;
    cc = 0.25 * (c[2].x - c[0].z) / a;
    d = 0.25 * (c[0].y - c[1].x) / a;
  } else {
    const double xd = 1 + xx - (yy + zz), yd = 1 + yy - (xx + zz), zd = 1 + zz - (xx + yy);
    if (xd > 1) {
      b = 0.5 * std::sqrt(xd);
      cc = 0.25 * (c[1].x + c[0].y) / b;
      d = 0.25 * (c[2].x + c[0].z) / b;
      a = 0.25 * (c[1].z - c[2].y) / b;
    } else if (yd > 1) {
      cc = 0.5 * std::sqrt(yd);
      b = 0.25 * (c[1].x + c[0].y) / cc;
      d = 0.25 * (c[2].y + c[1].z) / cc;
      a = 0.25 * (c[2].x - c[0].z) / cc;
    } else {
      d = 0.5 * std::sqrt(zd);
      b = 0.25 * (c[2].x + c[0].z) / d;
      cc = 0.25 * (c[2].y + c[1].z) / d;
      a = 0.25 * (c[0].y - c[1].x) / d;
    }
    if (a < 0) b = -b, cc = -cc, d = -d;
  }
  return {b, cc, d};
}

/// Sets the sizes. Some files of three dimensions have dim[0] = 4 and dim[4] = 0.
void set_sizes(Random& random, int times, Header& h, Sample& sample) {
  const std::array<int, 3>& sizes = sample.truth.sizes;
  const bool zero_time = times == 1 && random.chance(15);
  const int dim[] = {times > 1 || zero_time ? 4 : random.one_of({3, 3, 4, 5}),
                     sizes[0],
                     sizes[1],
                     sizes[2],
                     zero_time ? 0 : times,
                     1,
                     1,
                     1};
  for (size_t i = 0; i < 8; ++i) h.set_size(40 + 2 * i, 16 + 8 * i, dim[i]);
  sample.must_be_noted = zero_time;
}

void set_sform(Random& random, const std::array<Vec3d, 3>& steps, Vec3d origin, Header& h) {
  h.set_code(254, 348, random.between(1, 4));
  for (size_t i = 0; i < 3; ++i) {
    h.set_real(280 + 4 * i, 400 + 8 * i, steps[i].x);
    h.set_real(296 + 4 * i, 432 + 8 * i, steps[i].y);
    h.set_real(312 + 4 * i, 464 + 8 * i, steps[i].z);
  }
  h.set_real(292, 424, origin.x);
  h.set_real(308, 456, origin.y);
  h.set_real(324, 488, origin.z);
}

/// `qfac`: -1 if the steps are left-handed, else 1.
void set_qform(Random& random, const std::array<Vec3d, 3>& steps, Vec3d origin, double qfac,
               Header& h) {
  h.set_code(252, 344, random.between(1, 4));
  std::array<Vec3d, 3> columns;
  for (size_t i = 0; i < 3; ++i) columns[i] = steps[i] * (1 / length(steps[i]));
  columns[2] = columns[2] * qfac;
  const auto q = quaternion_of(columns);
  for (size_t i = 0; i < 3; ++i) h.set_real(256 + 4 * i, 352 + 8 * i, q[i]);
  h.set_real(268, 376, origin.x);
  h.set_real(272, 384, origin.y);
  h.set_real(276, 392, origin.z);
}

/// Sets the unit and the transform, which are in RAS. Returns a description.
std::string set_transform(Random& random, Header& h, Sample& sample) {
  Truth& truth = sample.truth;
  const bool sform = random.chance(60), qform = !sform || random.chance(40);
  const auto steps = choose_steps(random, !qform);
  const Vec3d origin = choose_place(random);
  const int unit_code = random.one_of({2, 2, 1, 3, 0});
  const double unit = unit_code == 1 ? 1000 : unit_code == 3 ? 0.001 : 1;
  sample.must_be_noted |= unit_code == 0;
  if (h.is_two()) {
    h.set(500, static_cast<int32_t>(unit_code | 8));
  } else {
    h.set(123, static_cast<uint8_t>(unit_code | 8));
  }
  const double qfac = dot(steps[0], cross(steps[1], steps[2])) < 0 ? -1 : 1;
  h.set_real(76, 104, qfac);
  for (size_t i = 0; i < 3; ++i) h.set_real(80 + 4 * i, 112 + 8 * i, length(steps[i]));
  if (sform) set_sform(random, steps, origin, h);
  if (qform) set_qform(random, steps, origin, qfac, h);
  for (size_t i = 0; i < 3; ++i) truth.steps[i] = with_signs(steps[i], {-1, -1, 1}) * unit;
  truth.origin = with_signs(origin, {-1, -1, 1}) * unit;
  return fmt::format("{}{}, unit {}", sform ? " sform" : "", qform ? " qform" : "", unit_code);
}

void set_scaling(Random& random, Header& h, Truth& truth) {
  if (random.chance(35)) {
    const double slope = random.one_of({0.5, 2.0, -1.0, 0.25}),
                 intercept = random.one_of({0.0, -100.0});
    h.set_real(112, 176, slope);
    h.set_real(116, 184, intercept);
    for (double& value : truth.values) value = value * slope + intercept;
  } else if (random.chance(30)) {
    h.set_real(112, 176, std::nan(""));
    h.set_real(116, 184, std::nan(""));
  }
}

/// Damages the uncompressed header in the file `with_header`.
void add_damages(const std::string& with_header, bool is_two, bool big_endian, Number type,
                 Sample& sample) {
  const size_t at = is_two ? 24 + (big_endian ? 7 : 0) : 42 + (big_endian ? 1 : 0);
  sample.damages.push_back([=](auto& files) {
    char& low = files[with_header][at];
    low = low == 2 ? 3 : 2;
  });
  sample.damages.push_back([=](auto& files) {  // another type of a different size
    const std::string raw = {static_cast<char>(bytes_of(type) == 2 ? 16 : 4), 0};
    std::string& h = files[with_header];
    const size_t place = is_two ? 12 : 70;
    h[place] = big_endian ? 0 : raw[0];
    h[place + 1] = big_endian ? raw[0] : '\0';
  });
}

}  // namespace

Sample make_nifti(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const auto type = static_cast<Number>(random.between(0, 9));
  choose_voxels(random, type, truth);
  const int times = random.chance(25) ? random.between(2, 3) : 1;
  const int step = random.between(0, times - 1);
  if (times > 1) sample.options.time_step = step;
  std::vector<double> stored;
  for (int t = 0; t < times; ++t) {
    for (const double value : truth.values) stored.push_back(t == step ? value : 3);
  }
  const bool is_two = random.chance(35), big_endian = random.chance(40), pair = random.chance(20);
  Header h(is_two, big_endian);
  if (is_two) {
    h.set_text(4, std::string(pair ? "ni2\0\r\n\032\n" : "n+2\0\r\n\032\n", 8));
  } else {
    h.set_text(344, std::string(pair ? "ni1\0" : "n+1\0", 4));
  }
  set_sizes(random, times, h, sample);
  h.set(is_two ? 12 : 70, datatype_code(type));
  h.set(is_two ? 14 : 72, static_cast<int16_t>(8 * bytes_of(type)));
  const std::string transform = set_transform(random, h, sample);
  set_scaling(random, h, truth);
  const auto header_bytes = static_cast<int>(h.bytes().size());
  const int offset = pair ? random.one_of({0, 0, 16}) : header_bytes + random.one_of({4, 20});
  if (is_two) {
    h.set(168, static_cast<int64_t>(offset));
  } else {
    h.set(108, static_cast<float>(offset));
  }

  const std::string voxels = binary_of(stored, type, big_endian);
  const bool gzip = random.chance(40);
  if (pair) {
    sample.main = random.one_of({"v.hdr", "v.img"});
    sample.files["v.hdr"] = h.bytes();
    sample.removable = {"v.hdr", "v.img"};
    sample.files["v.img"] = std::string(static_cast<size_t>(offset), 'e') + voxels;
  } else {
    const std::string padding(static_cast<size_t>(offset - header_bytes), '\0');
    const std::string all = h.bytes() + padding + voxels;
    sample.main = gzip && random.chance(70) ? "v.nii.gz" : "v.nii";  // compressed ".nii" too
    sample.files[sample.main] = gzip ? gzipped(all) : all;
  }
  sample.text = fmt::format("NIfTI-{}{}{}{}{}", is_two ? 2 : 1, pair ? " pair" : "", transform,
                            big_endian ? ", big-endian" : "", gzip ? ", gzip" : "");
  if (!gzip || pair) {
    add_damages(pair ? "v.hdr" : sample.main, is_two, big_endian, type, sample);
  }
  return sample;
}

}  // namespace isosplat::conformance
