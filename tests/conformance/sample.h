#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "shared/import/open_volume.h"

// Shared by the generators of the conformance suite. A generator is written from its format's
// specification, so nothing here may use code of the importers except the types of their interface.
namespace isosplat::conformance {

/// A repeatable source of random choices.
class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}

  int between(int low, int high) { return low + static_cast<int>(engine_() % (high - low + 1)); }
  bool chance(int percent) { return between(1, 100) <= percent; }
  double real(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  template <class T>
  T one_of(std::initializer_list<T> all) {
    return *(all.begin() + between(0, static_cast<int>(all.size()) - 1));
  }

 private:
  std::mt19937_64 engine_;
};

enum class Number { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

inline size_t bytes_of(Number type) {
  constexpr size_t kBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kBytes[static_cast<size_t>(type)];
}

/// The volume that a file describes: the expected result.
struct Truth {
  std::array<int, 3> sizes{};    ///< voxels along the axes, in file order
  std::vector<double> values;    ///< x fastest; NaN: absent
  std::array<Vec3d, 3> steps{};  ///< step vector from voxel to voxel, LPS, mm
  Vec3d origin{0, 0, 0};         ///< centre of voxel (0, 0, 0), LPS, mm
};

/// A volume as files, and how it must be read.
struct Sample {
  std::map<std::string, std::string> files;  ///< by file name
  std::string main;                          ///< the file to open; empty: the folder
  import::ImportOptions options;
  Truth truth;
  std::string text;            ///< description for messages
  bool must_be_noted = false;  ///< the header leaves something undefined: a note is required
  bool needs_choice = false;   ///< without the options that choose a volume, opening it is an error
  /// Parts of notes that would contradict the content of the file.
  std::vector<std::string> false_notes;
  bool may_be_longer = false;  ///< bytes after the last voxel are allowed
  /// Files whose beginning or end has no meaning, so that missing bytes cannot be detected.
  std::set<std::string> open_ended;
  /// Sizes to which the only file can be cut so that it still describes a valid, but different,
  /// volume.
  std::set<int> whole_at;
  bool try_allowances = true;       ///< false: the remaining data may be a different volume
  std::set<std::string> removable;  ///< files without which the volume is incomplete
  /// Changes that make the files contradictory or incomplete: none of them may be read as a wrong
  /// volume.
  std::vector<std::function<void(std::map<std::string, std::string>&)>> damages;
};

/// A format's generator.
struct Format {
  const char* name;
  Sample (*make)(Random&);
};

// Add new formats here and to the list in conformance_test.cpp.
Sample make_nrrd(Random& random);
Sample make_meta_image(Random& random);
Sample make_nifti(Random& random);
Sample make_mgh(Random& random);
Sample make_mrc(Random& random);
Sample make_netcdf(Random& random);
Sample make_npy(Random& random);
Sample make_hdf5(Random& random);
Sample make_vtk(Random& random);
Sample make_vtk_xml(Random& random);
Sample make_cube(Random& random);
Sample make_vasp(Random& random);
Sample make_xsf(Random& random);
Sample make_dx(Random& random);
Sample make_npz(Random& random);
Sample make_tiff(Random& random);
Sample make_tiff_series(Random& random);
Sample make_raw(Random& random);
Sample make_dicom(Random& random);
Sample make_dicom_mapping(Random& random);
Sample make_dicom_mosaic(Random& random);
Sample make_dicom_segments(Random& random);

// Helpers of generators ---------------------------------------------------------------------------

/// Sizes and values that a type can hold. Voxels have different values, so that an exchange of
/// voxels is detected.
inline void choose_voxels(Random& random, Number type, Truth& truth, int largest = 6) {
  for (int& size : truth.sizes) size = random.between(2, largest);
  const int count = truth.sizes[0] * truth.sizes[1] * truth.sizes[2];
  const int start = random.between(0, 20);
  for (int i = 0; i < count; ++i) {
    double value = start + i % 97 + (i / 97) * 97 % 100;
    if (type == Number::i8 || type == Number::i16) value -= 100;
    if (type == Number::i32 || type == Number::i64) value = value * 1000 - 50000;
    if (type == Number::u32 || type == Number::u64) value *= 1000;
    if (type == Number::f32 || type == Number::f64) value = value * 0.25 - 10;
    truth.values.push_back(value);
  }
}

inline void append(std::string& out, const void* bytes, size_t count, bool big_endian) {
  const auto* from = static_cast<const char*>(bytes);
  for (size_t i = 0; i < count; ++i) out.push_back(from[big_endian ? count - 1 - i : i]);
}

template <class T>
void put(std::string& out, T value, bool big_endian) {
  append(out, &value, sizeof value, big_endian);
}

/// One number in binary. This machine is little-endian.
inline void put_number(std::string& out, Number type, double value, bool big_endian) {
  switch (type) {
    case Number::u8:
      return put(out, static_cast<uint8_t>(static_cast<int64_t>(value)), big_endian);
    case Number::i8:
      return put(out, static_cast<int8_t>(static_cast<int64_t>(value)), big_endian);
    case Number::u16:
      return put(out, static_cast<uint16_t>(static_cast<int64_t>(value)), big_endian);
    case Number::i16:
      return put(out, static_cast<int16_t>(static_cast<int64_t>(value)), big_endian);
    case Number::u32:
      return put(out, static_cast<uint32_t>(static_cast<int64_t>(value)), big_endian);
    case Number::i32:
      return put(out, static_cast<int32_t>(static_cast<int64_t>(value)), big_endian);
    case Number::u64:
      return put(out, static_cast<uint64_t>(value), big_endian);
    case Number::i64:
      return put(out, static_cast<int64_t>(value), big_endian);
    case Number::f32:
      return put(out, static_cast<float>(value), big_endian);
    case Number::f64:
      return put(out, value, big_endian);
  }
}

inline std::string text_of(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

/// Numbers as text, several per line, with a line end after the last line.
inline std::string text_of(const std::vector<double>& values, Random& random) {
  std::string out;
  for (size_t i = 0; i < values.size(); ++i) {
    out += text_of(values[i]) + (random.chance(20) || i + 1 == values.size() ? "\n" : " ");
  }
  return out;
}

inline std::string binary_of(const std::vector<double>& values, Number type, bool big_endian) {
  std::string out;
  for (const double value : values) put_number(out, type, value, big_endian);
  return out;
}

/// Three perpendicular axes with lengths, right- or left-handed; sometimes parallel to the axes of
/// the world; sometimes sheared, where the format allows it.
inline std::array<Vec3d, 3> choose_steps(Random& random, bool may_shear = false) {
  std::array<Vec3d, 3> axes{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  if (random.chance(60)) {
    Vec3d a{random.real(-1, 1), random.real(-1, 1), random.real(-1, 1)};
    a = a * (1 / length(a));
    Vec3d b = cross(a, Vec3d{random.real(-1, 1), random.real(-1, 1), random.real(-1, 1)});
    b = b * (1 / length(b));
    axes = {a, b, cross(a, b)};
  }
  for (int i = 2; i > 0; --i) std::swap(axes[i], axes[random.between(0, i)]);
  for (Vec3d& axis : axes) {
    axis = axis * ((random.chance(40) ? -1 : 1) * random.between(4, 40) * 0.125);
  }
  if (may_shear && random.chance(30)) {
    axes[1] = axes[1] + axes[0] * random.real(-0.4, 0.4) + axes[2] * random.real(-0.4, 0.4);
  }
  return axes;
}

inline Vec3d choose_place(Random& random) {
  return {random.between(-400, 400) * 0.25, random.between(-400, 400) * 0.25,
          random.between(-400, 400) * 0.25};
}

/// Converts a position between LPS and a frame with other signs of x, y and z, such as RAS. The
/// conversion is its own inverse.
inline Vec3d with_signs(Vec3d v, std::array<int, 3> signs) {
  return {v.x * signs[0], v.y * signs[1], v.z * signs[2]};
}

std::string gzipped(const std::string& bytes, bool zlib = false);

}  // namespace isosplat::conformance
