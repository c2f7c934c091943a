// Reads files that the HDF5 library has written (hdf5/make_files.py): their volumes and their
// errors.
#include <fstream>
#include <sstream>

#include "shared/import/hdf5/hdf5.h"
#include "tests/native/import_checks.h"

namespace isosplat::import {
namespace {

using test::error_of;
using test::expect_error;
using test::expect_note;
using test::open;
using test::read_all;
using test::TempFolder;
using test::write_file;

std::filesystem::path file_of(const std::string& name) {
  return std::filesystem::path(ISOSPLAT_SOURCE_DIR) / "tests/native/hdf5" / (name + ".h5");
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The values that make_files.py writes, x fastest.
std::vector<double> voxels(Index3 n = {5, 6, 7}) {
  std::vector<double> values;
  for (int z = 0; z < n.z; ++z) {
    for (int y = 0; y < n.y; ++y) {
      for (int x = 0; x < n.x; ++x) values.push_back(100 * z + 10 * y + x);
    }
  }
  return values;
}

void expect_volume(const std::string& name, VoxelType type, Index3 n = {5, 6, 7},
                   const ImportOptions& options = {}) {
  SCOPED_TRACE(name);
  auto volume = open(file_of(name), options);
  ASSERT_TRUE(volume.source);
  EXPECT_EQ(volume.source->header().format, "HDF5");
  EXPECT_EQ(volume.source->header().type, type);
  EXPECT_EQ(volume.source->header().grid.voxels, n);
  EXPECT_EQ(read_all(*volume.source), voxels(n));
}

ImportOptions dataset(const std::string& path) {
  ImportOptions options;
  options.dataset = path;
  return options;
}

TEST(ImportHdf5, ReadsEveryLayoutAndIndex) {
  expect_volume("contiguous", VoxelType::i16);
  expect_volume("compact", VoxelType::i16);
  expect_volume("continued", VoxelType::i16);
  expect_volume("filtered", VoxelType::u16);
  expect_volume("user_block", VoxelType::f32);
  expect_volume("latest_fixed", VoxelType::i16);
  expect_volume("latest_plain", VoxelType::i16);
  expect_volume("latest_single", VoxelType::i16);
  expect_volume("latest_implicit", VoxelType::i16);
  expect_volume("latest_pages", VoxelType::i16, {10, 10, 12});
  expect_volume("limited", VoxelType::i16);
  expect_volume("growing", VoxelType::i16);
  expect_volume("growing_rows", VoxelType::i16);
  expect_volume("growing_all", VoxelType::i16);
  expect_volume("growing_plain", VoxelType::i16);
  expect_volume("lzf", VoxelType::i16);
  auto lz4 = open(file_of("lz4"));
  const auto values = read_all(*lz4.source);
  for (size_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], static_cast<double>(i / 30));
}

TEST(ImportHdf5, LinksAndAttributesMayBeInHeaps) {
  auto volume = open(file_of("heaps"));
  EXPECT_EQ(read_all(*volume.source), voxels());
  EXPECT_NEAR(volume.source->header().grid.spacing.z, 0.003, 1e-12);
  ASSERT_EQ(volume.notes.size(), 1u);
  expect_note(volume, "does not name the array's axes");
}

TEST(ImportHdf5, SlicesCanBeReadInAnyOrder) {
  for (const char* name : {"filtered", "latest_pages", "contiguous"}) {
    auto volume = open(file_of(name));
    const Index3 n = volume.source->header().grid.voxels;
    const auto all = voxels(n);
    const auto slice = static_cast<size_t>(n.x * n.y);
    for (const int32_t z : {n.z - 1, 0, 3, 4, 3, 1}) {
      std::vector<std::byte> raw(slice * 2);
      ASSERT_TRUE(volume.source->read_slices(z, 1, raw));
      for (size_t i = 0; i < slice; ++i) {
        uint16_t value = 0;
        std::memcpy(&value, raw.data() + 2 * i, 2);
        ASSERT_EQ(value, all[static_cast<size_t>(z) * slice + i]) << name << " " << z;
      }
    }
  }
}

TEST(ImportHdf5, ChunksThatWereNotWrittenHaveTheFillValue) {
  auto volume = open(file_of("sparse"));
  const auto values = read_all(*volume.source);
  const auto all = voxels();
  for (size_t i = 0; i < values.size(); ++i) {
    const size_t x = i % 5, y = i / 5 % 6, z = i / 30;
    const bool is_written = x < 4 && ((z < 4 && y < 4) || (z >= 4 && y >= 4));
    ASSERT_EQ(values[i], is_written ? all[i] : -7) << x << " " << y << " " << z;
  }
}

TEST(ImportHdf5, ADatasetIsChosen) {
  expect_error(file_of("several"),
               "expected one volume, found 3: /a/b/half (f16, 7 × 6 × 5), /a/b/long (i64, 7 × 6 × "
               "5), /again (i8, 7 × 6 × 5): choose one with --dataset");
  expect_volume("several", VoxelType::f32, {5, 6, 7}, dataset("/a/b/half"));
  expect_volume("several", VoxelType::i64, {5, 6, 7}, dataset("a/b/long"));
  expect_volume("several", VoxelType::i64, {5, 6, 7}, dataset("/a/up/b/long"));
  auto mask = open(file_of("several"), dataset("/mask"));
  EXPECT_EQ(mask.source->header().type, VoxelType::i8);
  EXPECT_EQ(read_all(*mask.source)[1], 1);
  EXPECT_EQ(hdf5_datasets(file_of("several")).value(),
            (std::vector<std::string>{"/a/b/half", "/a/b/long", "/again"}));
  expect_error(file_of("several"), "expected a dataset /none, found /a/b/half", dataset("/none"));
  expect_error(file_of("several"), "expected a dataset /a, found /a/b/half", dataset("/a"));
  expect_error(file_of("several"), "found the shape (6, 5) in /image", dataset("/image"));
  expect_error(file_of("several"), "found sequences in /name", dataset("/name"));
  expect_error(file_of("several"),
               "found axes of 3, 4, 5, 3 in /colours: save one volume of it with python3 -c "
               "\"import sys, h5py, numpy; numpy.save('volume.npy', "
               "h5py.File(sys.argv[1])[sys.argv[2]][0])\" " +
                   file_of("several").string() + " /colours",
               dataset("/colours"));
}

TEST(ImportHdf5, TheFilesDefaultIsOpened) {
  auto volume = open(file_of("nexus"));
  const VolumeGrid& grid = volume.source->header().grid;
  EXPECT_EQ(volume.source->header().type, VoxelType::u16);
  EXPECT_EQ(read_all(*volume.source), voxels());
  EXPECT_TRUE(volume.notes.empty()) << volume.notes.front();
  const Vec3d first = grid.world({0, 0, 0}), last = grid.world({4, 5, 6});
  EXPECT_NEAR(first.x, 0, 1e-9);
  EXPECT_NEAR(first.y, 10, 1e-9);
  EXPECT_NEAR(first.z, -0.003, 1e-9);
  EXPECT_NEAR(last.x, 8, 1e-9);
  EXPECT_NEAR(last.y, 11.25, 1e-9);
  EXPECT_NEAR(last.z, 0, 1e-9);
  EXPECT_EQ(open(file_of("nexus"), dataset("/entry/data/errors")).source->header().type,
            VoxelType::f32);
}

TEST(ImportHdf5, SpacingOfElementSize) {
  const Vec3d spacing = open(file_of("contiguous")).source->header().grid.spacing;
  EXPECT_NEAR(spacing.x, 0.0005, 1e-12);
  EXPECT_NEAR(spacing.y, 0.002, 1e-12);
  EXPECT_NEAR(spacing.z, 0.003, 1e-12);
  const Vec3d other = open(file_of("continued")).source->header().grid.spacing;
  EXPECT_NEAR(other.x, 3, 1e-12);
  EXPECT_NEAR(other.z, 1, 1e-12);
  ImportOptions options;
  options.spacing = Vec3d{4, 5, 6};
  const Vec3d given = open(file_of("contiguous"), options).source->header().grid.spacing;
  EXPECT_EQ(given.x, 4);
  EXPECT_EQ(given.z, 6);
  auto without = open(file_of("filtered"));
  expect_note(without, "no voxel spacing");
  expect_note(without, "z, y and x");
}

TEST(ImportHdf5, AxesOfIlastik) {
  ImportOptions options;
  options.spacing = Vec3d{1, 2, 3};
  auto volume = open(file_of("ilastik"), options);
  const VolumeGrid& grid = volume.source->header().grid;
  EXPECT_EQ(grid.voxels, (Index3{7, 6, 5}));
  const auto values = read_all(*volume.source);
  for (int c = 0; c < 5; ++c) {
    for (int b = 0; b < 6; ++b) {
      for (int a = 0; a < 7; ++a) {
        const Vec3d at = grid.world({double(a), double(b), double(c)});
        EXPECT_EQ(values[static_cast<size_t>((c * 6 + b) * 7 + a)],
                  100 * std::lround(at.z / 3) + 10 * std::lround(at.y / 2) + std::lround(at.x));
      }
    }
  }
}

TEST(ImportHdf5, PackedValues) {
  auto volume = open(file_of("packed"));
  const VolumeHeader& header = volume.source->header();
  EXPECT_EQ(header.slope, 0.5);
  EXPECT_EQ(header.intercept, 10);
  expect_note(volume, "322");  // 10 + 624 / 2 stands for no value
}

TEST(ImportHdf5, Errors) {
  expect_error(
      file_of("szip"),
      "found compression with SZIP: save the largest array of the file for NumPy with python3 -c");
  expect_error(file_of("virtual"), "a virtual array");
  expect_error(file_of("minc"), "found MINC");
  expect_error(file_of("complex"), "found records in /volume");
  expect_error(file_of("flat"), "found the shape (6, 5) in /image");
  expect_error(file_of("steps"), "found axes of 2, 7, 6, 5 in /volume");
  expect_error(file_of("unwritten"), "found none written");
  expect_error(file_of("empty"), "an HDF5 file without arrays");
  ImportOptions options;
  options.time_step = 1;
  expect_error(file_of("contiguous"), "--time-step from 0 to 0", options);
  const TempFolder folder;
  write_file(folder / "v.h5.gz", test::deflated(content_of(file_of("contiguous"))));
  EXPECT_EQ(error_of(folder / "v.h5.gz"), "");
}

TEST(ImportHdf5, AFileThatIsCutIsAnError) {
  const TempFolder folder;
  for (const char* name : {"contiguous", "compact", "filtered", "latest_fixed", "latest_pages",
                           "heaps", "growing_all"}) {
    const std::string file = content_of(file_of(name));
    for (size_t size = 0; size < file.size(); size += 1 + size / 50) {
      write_file(folder / "v.h5", file.substr(0, size));
      EXPECT_NE(error_of(folder / "v.h5"), "") << name << " " << size;
    }
  }
}

/// The old format has no checksums of metadata, so a change may not be noticed. But reading must
/// end, and must read nothing outside of the file (the sanitizers check this).
TEST(ImportHdf5, AnyChangedByteEndsInAVolumeOrAnError) {
  const TempFolder folder;
  for (const char* name : {"filtered", "latest_fixed", "latest_implicit", "sparse", "ilastik",
                           "lz4", "growing", "growing_all", "heaps"}) {
    const std::string file = content_of(file_of(name));
    const size_t step = 1 + file.size() / 1500;
    for (size_t i = 0; i < file.size(); i += step) {
      std::string changed = file;
      changed[i] = static_cast<char>(changed[i] ^ (i / step % 2 == 0 ? 0xff : 1));
      write_file(folder / "v.h5", changed);
      auto volume = open_volume(folder / "v.h5", {});
      if (!volume) continue;
      const VolumeHeader& header = volume->source->header();
      const Index3 n = header.grid.voxels;
      if (int64_t{n.x} * n.y > 1 << 16) continue;
      std::vector<std::byte> slice(static_cast<size_t>(n.x * n.y) * voxel_bytes(header.type));
      for (const int32_t z : {0, n.z - 1}) {
        static_cast<void>(volume->source->read_slices(z, 1, slice));
      }
    }
  }
}

TEST(ImportHdf5, DamagedVoxelsAreNoticed) {
  const TempFolder folder;
  const std::string file = content_of(file_of("filtered"));
  // The first chunk's compressed data begin with the header of zlib.
  const size_t begin = file.find("\x78\x5e", 2000);
  ASSERT_NE(begin, file.npos);
  std::string changed = file;
  changed[begin + 20] = static_cast<char>(changed[begin + 20] ^ 1);
  write_file(folder / "v.h5", changed);
  expect_error(folder / "v.h5", "the checksum of a chunk differs");
}

}  // namespace
}  // namespace isosplat::import
