#pragma once

#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cstring>

#include "shared/import/open_volume.h"
#include "tests/native/test_files.h"

// Small volume files of every format, written byte by byte.
namespace isosplat::test {

/// The value at (x, y, z) of the volumes that these tests write. All values are different in a
/// volume of up to 9³ voxels.
inline int pattern(int64_t x, int64_t y, int64_t z) {
  return static_cast<int>(x + 9 * y + 81 * z);
}

template <class T>
std::vector<T> pattern_voxels(Index3 n, double scale = 1, double offset = 0) {
  std::vector<T> values;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        values.push_back(static_cast<T>(pattern(x, y, z) * scale + offset));
      }
    }
  }
  return values;
}

template <class T>
std::vector<T> byte_swapped(std::vector<T> values) {
  for (T& value : values) {
    auto* bytes = reinterpret_cast<unsigned char*>(&value);
    std::reverse(bytes, bytes + sizeof(T));
  }
  return values;
}

/// `window_bits`: 31 for gzip, 15 for zlib.
inline std::string deflated(const std::string& text, int window_bits = 31) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, text.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

inline std::string nrrd_header(Index3 n, const std::string& type, const std::string& more) {
  return fmt::format("NRRD0004\ntype: {}\ndimension: 3\nsizes: {} {} {}\n{}", type, n.x, n.y, n.z,
                     more);
}

/// The values of all voxels of an open volume, as doubles, x fastest.
inline std::vector<double> read_all(VolumeSource& source) {
  const VolumeHeader& header = source.header();
  const Index3 n = header.grid.voxels;
  const size_t count =
      static_cast<size_t>(n.x) * static_cast<size_t>(n.y) * static_cast<size_t>(n.z);
  std::vector<std::byte> bytes(count * voxel_bytes(header.type));
  const auto read = source.read_slices(0, n.z, bytes);
  EXPECT_TRUE(read) << read.error().message;
  std::vector<double> values(count);
  with_voxel_type(header.type, [&]<class T>(T) {
    for (size_t i = 0; i < count; ++i) {
      T voxel;
      std::memcpy(&voxel, bytes.data() + i * sizeof(T), sizeof(T));
      values[i] = header.value(static_cast<double>(voxel));
    }
  });
  return values;
}

/// A NIfTI-1 file with header and voxels in one file.
struct NiftiFile {
  std::vector<int16_t> sizes;
  int16_t data_type = 4;
  int16_t bits = 16;
  float slope = 0, intercept = 0;
  std::array<std::array<float, 4>, 3> rows{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};  ///< RAS
  int16_t affine_code = 1;    ///< "sform_code": scanner coordinates
  bool has_rotation = false;  ///< "qform": the identity
  std::string voxels;
  float time_distance = 0, time_offset = 0;
  char time_units = 0;  ///< the bits of xyzt_units

  std::string bytes() const {
    std::string h(352, '\0');
    put(h, 0, int32_t{348});
    put(h, 40, static_cast<int16_t>(sizes.size()));
    for (size_t i = 0; i < 7; ++i) {
      put(h, 42 + 2 * i, i < sizes.size() ? sizes[i] : int16_t{1});
    }
    put(h, 70, data_type);
    put(h, 72, bits);
    put(h, 76, 1.0f);
    for (size_t axis = 0; axis < 3; ++axis) {
      float squared = 0;
      for (size_t row = 0; row < 3; ++row) squared += rows[row][axis] * rows[row][axis];
      put(h, 80 + 4 * axis, std::sqrt(squared));
    }
    put(h, 108, 352.0f);
    put(h, 112, slope);
    put(h, 116, intercept);
    h[123] = static_cast<char>(2 | time_units);  // millimetres
    put(h, 92, time_distance);
    put(h, 136, time_offset);
    put(h, 252, static_cast<int16_t>(has_rotation));
    put(h, 254, affine_code);
    for (size_t row = 0; row < 3; ++row) {
      for (size_t i = 0; i < 4; ++i) put(h, 280 + 16 * row + 4 * i, rows[row][i]);
    }
    std::memcpy(&h[344], "n+1", 4);
    return h + voxels;
  }

 private:
  template <class T>
  static void put(std::string& header, size_t offset, T value) {
    std::memcpy(&header[offset], &value, sizeof(T));
  }
};

}  // namespace isosplat::test
