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

/// A header whose fields are set by their offsets.
class Header {
 public:
  Header(size_t bytes, bool big_endian) : bytes_(bytes, '\0'), big_endian_(big_endian) {}

  template <class T>
  void set(size_t offset, T value) {
    std::string raw;
    put(raw, value, big_endian_);
    std::copy(raw.begin(), raw.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
  }
  void set_text(size_t offset, const std::string& text) {
    bytes_.replace(offset, text.size(), text);
  }
  const std::string& bytes() const { return bytes_; }

 private:
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
  const size_t size = is_two ? 540 : 348;
  Header h(size, big_endian);
  h.set(0, static_cast<int32_t>(size));
  if (is_two) {
    h.set_text(4, std::string(pair ? "ni2\0\r\n\032\n" : "n+2\0\r\n\032\n", 8));
  } else {
    h.set_text(344, std::string(pair ? "ni1\0" : "n+1\0", 4));
  }
  const auto real = [&](size_t one, size_t two, double value) {
    if (is_two) {
      h.set(two, value);
    } else {
      h.set(one, static_cast<float>(value));
    }
  };
  const auto code = [&](size_t one, size_t two, int value) {
    if (is_two) {
      h.set(two, static_cast<int32_t>(value));
    } else {
      h.set(one, static_cast<int16_t>(value));
    }
  };
  // Some files of three dimensions have dim[0] = 4 and dim[4] = 0.
  const bool zero_time = times == 1 && random.chance(15);
  const int dim[] = {times > 1 || zero_time ? 4 : random.one_of({3, 3, 4, 5}),
                     truth.sizes[0],
                     truth.sizes[1],
                     truth.sizes[2],
                     zero_time ? 0 : times,
                     1,
                     1,
                     1};
  for (size_t i = 0; i < 8; ++i) {
    if (is_two) {
      h.set(16 + 8 * i, static_cast<int64_t>(dim[i]));
    } else {
      h.set(40 + 2 * i, static_cast<int16_t>(dim[i]));
    }
  }
  h.set(is_two ? 12 : 70, datatype_code(type));
  h.set(is_two ? 14 : 72, static_cast<int16_t>(8 * bytes_of(type)));
  sample.must_be_noted = zero_time;

  // The transform, in RAS.
  const bool sform = random.chance(60), qform = !sform || random.chance(40);
  const auto steps = choose_steps(random, !qform);
  const Vec3d origin = choose_place(random);
  const int unit_code = random.one_of({2, 2, 1, 3, 0});
  const double unit = unit_code == 1 ? 1000 : unit_code == 3 ? 0.001 : 1;
  sample.must_be_noted |= unit_code == 0;
  if (is_two) {
    h.set(500, static_cast<int32_t>(unit_code | 8));
  } else {
    h.set_text(123, std::string(1, static_cast<char>(unit_code | 8)));
  }
  const bool left_handed = dot(steps[0], cross(steps[1], steps[2])) < 0;
  const double qfac = left_handed ? -1 : 1;
  real(76, 104, qfac);
  for (size_t i = 0; i < 3; ++i) real(80 + 4 * i, 112 + 8 * i, length(steps[i]));
  if (sform) {
    code(254, 348, random.between(1, 4));
    for (size_t i = 0; i < 3; ++i) {
      real(280 + 4 * i, 400 + 8 * i, steps[i].x);
      real(296 + 4 * i, 432 + 8 * i, steps[i].y);
      real(312 + 4 * i, 464 + 8 * i, steps[i].z);
    }
    real(292, 424, origin.x);
    real(308, 456, origin.y);
    real(324, 488, origin.z);
  }
  if (qform) {
    code(252, 344, random.between(1, 4));
    std::array<Vec3d, 3> columns;
    for (size_t i = 0; i < 3; ++i) columns[i] = steps[i] * (1 / length(steps[i]));
    columns[2] = columns[2] * qfac;
    const auto q = quaternion_of(columns);
    for (size_t i = 0; i < 3; ++i) real(256 + 4 * i, 352 + 8 * i, q[i]);
    real(268, 376, origin.x);
    real(272, 384, origin.y);
    real(276, 392, origin.z);
  }
  for (size_t i = 0; i < 3; ++i) truth.steps[i] = with_signs(steps[i], {-1, -1, 1}) * unit;
  truth.origin = with_signs(origin, {-1, -1, 1}) * unit;

  if (random.chance(35)) {
    const double slope = random.one_of({0.5, 2.0, -1.0, 0.25}),
                 intercept = random.one_of({0.0, -100.0});
    real(112, 176, slope);
    real(116, 184, intercept);
    for (double& value : truth.values) value = value * slope + intercept;
  } else if (random.chance(30)) {
    real(112, 176, std::nan(""));
    real(116, 184, std::nan(""));
  }
  const int padding =
      pair ? random.one_of({0, 0, 16}) : static_cast<int>(size) + random.one_of({4, 20});
  if (is_two) {
    h.set(168, static_cast<int64_t>(padding));
  } else {
    h.set(108, static_cast<float>(padding));
  }
  std::string voxels = binary_of(stored, type, big_endian);
  const bool gzip = random.chance(40);
  if (pair) {
    sample.main = random.one_of({"v.hdr", "v.img"});
    sample.files["v.hdr"] = h.bytes();
    sample.removable = {"v.hdr", "v.img"};
    sample.files["v.img"] = std::string(static_cast<size_t>(padding), 'e') + voxels;
  } else {
    std::string all = h.bytes() + std::string(static_cast<size_t>(padding) - size, '\0') + voxels;
    sample.main = gzip && random.chance(70) ? "v.nii.gz" : "v.nii";  // compressed ".nii" too
    sample.files[sample.main] = gzip ? gzipped(all) : all;
  }
  sample.text = fmt::format("NIfTI-{}{}{}{}{}{}, unit {}", is_two ? 2 : 1, pair ? " pair" : "",
                            sform ? " sform" : "", qform ? " qform" : "",
                            big_endian ? " big-endian" : "", gzip ? " gzip" : "", unit_code);
  if (!gzip || pair) {
    const std::string with_header = pair ? "v.hdr" : sample.main;
    const size_t at = is_two ? 24 + (big_endian ? 7 : 0) : 42 + (big_endian ? 1 : 0);
    sample.damages.push_back([=](auto& files) {
      char& low = files[with_header][at];
      low = low == 2 ? 3 : 2;
    });
    sample.damages.push_back([=](auto& files) {  // another type of a different size
      const std::string raw = {static_cast<char>(bytes_of(type) == 2 ? 16 : 4), 0};
      std::string& h2 = files[with_header];
      const size_t place = is_two ? 12 : 70;
      h2[place] = big_endian ? 0 : raw[0];
      h2[place + 1] = big_endian ? raw[0] : '\0';
    });
  }
  return sample;
}

}  // namespace isosplat::conformance
