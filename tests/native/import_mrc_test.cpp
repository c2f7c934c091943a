#include <cmath>

#include "tests/native/import_checks.h"

namespace isosplat::import {
namespace {

using test::bytes_of;
using test::deflated;
using test::expect_error;
using test::expect_note;
using test::open;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

/// An MRC file of 5 × 4 × 3 voxels with a cell of 10 × 12 × 15 ångström. Fields are changed by the
/// number of their word, from 1 as in the specification.
struct MrcFile {
  std::string header = std::string(1024, '\0');
  std::string voxels = bytes_of(pattern_voxels<int16_t>(kSize));

  MrcFile() {
    const int32_t first[] = {5, 4, 3, 1, 0, 0, 0, 5, 4, 3};
    for (size_t i = 0; i < 10; ++i) set(1 + i, first[i]);
    const float cell[] = {10, 12, 15, 90, 90, 90};
    for (size_t i = 0; i < 6; ++i) set(11 + i, cell[i]);
    for (size_t i = 0; i < 3; ++i) set(17 + i, static_cast<int32_t>(i + 1));
    set(21, 200.0f);
    set(23, int32_t{1});
    set(28, int32_t{20140});
    text(53, "MAP ");
    text(54, "DD");
  }
  template <class T>
  MrcFile& set(size_t word, T value) {
    static_assert(sizeof value == 4);
    std::memcpy(&header[4 * (word - 1)], &value, 4);
    return *this;
  }
  MrcFile& text(size_t word, const std::string& value) {
    header.replace(4 * (word - 1), value.size(), value);
    return *this;
  }
  std::string bytes() const { return header + voxels; }
};

/// The voxels of the pattern as bytes that wrap at 256.
std::string byte_voxels() {
  return bytes_of(pattern_voxels<uint8_t>(kSize));
}

VolumeHeader header_of(const std::filesystem::path& path) {
  const OpenVolume volume = open(path);
  return volume.source ? volume.source->header() : VolumeHeader{};
}

TEST(ImportMrc, ReadsAMapAlsoCompressed) {
  const TempFolder folder;
  MrcFile file;
  file.set(24, int32_t{80});
  file.voxels = std::string(80, 'x') + file.voxels;
  write_file(folder / "head.mrc", file.bytes());
  write_file(folder / "head.map.gz", deflated(file.bytes()));
  for (const char* name : {"head.mrc", "head.map.gz"}) {
    auto volume = open(folder / name);
    EXPECT_TRUE(volume.notes.empty()) << volume.notes.front();
    const VolumeHeader& header = volume.source->header();
    EXPECT_EQ(header.format, "MRC");
    EXPECT_EQ(header.name, "head");
    EXPECT_EQ(header.type, VoxelType::i16);
    EXPECT_EQ(header.grid.voxels, kSize);
    EXPECT_NEAR(header.grid.spacing.x, 2e-7, 1e-15);
    EXPECT_NEAR(header.grid.spacing.y, 3e-7, 1e-15);
    EXPECT_NEAR(header.grid.spacing.z, 5e-7, 1e-15);
    EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize));
    EXPECT_EQ(format_of_file(folder / name), "MRC");
  }
}

TEST(ImportMrc, ReadsEveryHalfFloat) {
  const TempFolder folder;
  MrcFile file;
  file.set(1, int32_t{64}).set(2, int32_t{32}).set(3, int32_t{32}).set(4, int32_t{12});
  std::vector<uint16_t> halves(65536);
  for (size_t i = 0; i < halves.size(); ++i) halves[i] = static_cast<uint16_t>(i);
  file.voxels = bytes_of(halves);
  write_file(folder / "v.mrc", file.bytes());
  ImportOptions options;
  options.finds_missing_values = false;
  auto volume = open(folder / "v.mrc", options);
  ASSERT_EQ(volume.source->header().type, VoxelType::f32);
  const auto values = read_all(*volume.source);
  for (size_t i = 0; i < halves.size(); ++i) {
    const int exponent = static_cast<int>(i >> 10 & 31), fraction = static_cast<int>(i & 1023);
    double expected =
        exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
    if (exponent == 31) expected = fraction ? NAN : INFINITY;
    if (i & 0x8000) expected = -expected;
    if (std::isnan(expected)) {
      EXPECT_TRUE(std::isnan(values[i])) << i;
    } else {
      EXPECT_EQ(values[i], expected) << i;
    }
  }
}

TEST(ImportMrc, ReadsAnIncompleteFileOfHalfFloats) {
  const TempFolder folder;
  MrcFile file;
  file.set(4, int32_t{12});
  file.voxels = bytes_of(std::vector<uint16_t>(50, 0x3c00));  // 1; ten voxels are missing
  write_file(folder / "v.mrc", file.bytes());
  expect_error(folder / "v.mrc", "expected 120 bytes of voxels");
  ImportOptions options;
  options.allowed.add(Allowance::truncated);
  auto volume = open(folder / "v.mrc", options);
  const auto values = read_all(*volume.source);
  EXPECT_EQ(values[49], 1);
  EXPECT_TRUE(std::isnan(values[50]));
  EXPECT_TRUE(std::isnan(values[59]));
}

TEST(ImportMrc, SignOfBytes) {
  const TempFolder folder;
  const auto type_of = [&](const MrcFile& file) {
    write_file(folder / "v.mrc", file.bytes());
    return header_of(folder / "v.mrc").type;
  };
  MrcFile file;
  file.voxels = byte_voxels();
  file.set(4, int32_t{0}).set(21, 100.0f);
  EXPECT_EQ(type_of(file), VoxelType::i8);
  file.set(39, int32_t{1146047817});
  EXPECT_EQ(type_of(file), VoxelType::u8) << "IMOD without its flag";
  file.set(40, int32_t{1});
  EXPECT_EQ(type_of(file), VoxelType::i8) << "IMOD with its flag";
  file.set(39, int32_t{0}).set(21, 200.0f);
  EXPECT_EQ(type_of(file), VoxelType::u8) << "a value above 127";
  expect_note(open(folder / "v.mrc"), "read as unsigned bytes");
  file.set(21, 0.0f).set(28, int32_t{0});
  EXPECT_EQ(type_of(file), VoxelType::i8);
  expect_note(open(folder / "v.mrc"), "does not say whether its bytes are signed");
  file.set(20, 0.0f).set(21, 100.0f);  // the range may be that of other voxels
  EXPECT_EQ(type_of(file), VoxelType::i8);
  expect_note(open(folder / "v.mrc"), "does not say whether its bytes are signed");
  file.set(20, -100.0f);
  EXPECT_EQ(type_of(file), VoxelType::i8);
  EXPECT_TRUE(open(folder / "v.mrc").notes.empty());
}

TEST(ImportMrc, ReadsHalfBytes) {
  const TempFolder folder;
  const auto values_of = [](Index3 n) {
    std::vector<double> values;
    for (int i = 0; i < n.x * n.y * n.z; ++i) values.push_back(i * 7 % 16);
    return values;
  };
  /// Rows of bytes with two voxels, the first one in the low bits.
  const auto packed = [](const std::vector<double>& values, size_t columns) {
    std::string bytes;
    for (size_t row = 0; row < values.size(); row += columns) {
      for (size_t i = 0; i < columns; i += 2) {
        const int low = static_cast<int>(values[row + i]);
        const int high = i + 1 < columns ? static_cast<int>(values[row + i + 1]) : 9;
        bytes += static_cast<char>(low | high << 4);
      }
    }
    return bytes;
  };
  MrcFile file;
  file.voxels = packed(values_of(kSize), 5);
  file.set(4, int32_t{101});
  write_file(folder / "v.mrc", file.bytes());
  auto volume = open(folder / "v.mrc");
  EXPECT_EQ(volume.source->header().type, VoxelType::u8);
  EXPECT_EQ(read_all(*volume.source), values_of(kSize));
  write_file(folder / "v.mrc.gz", deflated(file.bytes()));
  EXPECT_EQ(read_all(*open(folder / "v.mrc.gz").source), values_of(kSize));
  write_file(folder / "v.mrc", file.bytes() + "x");
  expect_error(folder / "v.mrc", "2 more");
  write_file(folder / "v.mrc", file.bytes().substr(0, 1024 + 30));
  expect_error(folder / "v.mrc", "the file is incomplete");

  // IMOD's flag: NX counts bytes.
  const Index3 wide{10, 4, 3};
  MrcFile flagged;
  flagged.voxels = packed(values_of(wide), 10);
  flagged.set(4, int32_t{0}).set(39, int32_t{1146047817}).set(40, int32_t{16});
  write_file(folder / "v.mrc", flagged.bytes());
  volume = open(folder / "v.mrc");
  EXPECT_EQ(volume.source->header().grid.voxels, wide);
  EXPECT_NEAR(volume.source->header().grid.spacing.x, 2e-7, 1e-12);
  EXPECT_EQ(read_all(*volume.source), values_of(wide));
}

TEST(ImportMrc, FieldsThatAreNotAppliedAreNoted) {
  const TempFolder folder;
  MrcFile turned;  // CCP4: by 90° about z
  turned.set(25, int32_t{1}).set(27, -1.0f).set(29, 1.0f).set(34, 1.0f).set(28, int32_t{0});
  write_file(folder / "v.map", turned.bytes());
  expect_note(open(folder / "v.map"), "(LSKFLG, SKWMAT, SKWTRN), which is not applied");
  MrcFile identity;
  identity.set(25, int32_t{1}).set(26, 1.0f).set(30, 1.0f).set(34, 1.0f).set(28, int32_t{0});
  write_file(folder / "v.map", identity.bytes());
  EXPECT_TRUE(open(folder / "v.map").notes.empty());
  identity.set(35, 10.0f);
  write_file(folder / "v.map", identity.bytes());
  expect_note(open(folder / "v.map"), "which is not applied");
  write_file(folder / "v.mrcs", MrcFile().bytes());
  expect_note(open(folder / "v.mrcs"), "the sections are separate images");
}

TEST(ImportMrc, ReadsFilesFromBefore2000ByTheirName) {
  const TempFolder folder;
  MrcFile file;
  file.text(53, std::string(8, '\0'));
  write_file(folder / "v.mrc", file.bytes());
  auto volume = open(folder / "v.mrc");
  EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize));
  expect_note(volume, "they are little-endian");
  write_file(folder / "v.rec.gz", deflated(file.bytes()));
  EXPECT_EQ(header_of(folder / "v.rec.gz").format, "MRC");
  write_file(folder / "v.dat", file.bytes());
  expect_error(folder / "v.dat", "no known signature");
  ImportOptions raw;  // .rec is also a name of raw files
  raw.dims = {16, 8, 8};
  raw.type = VoxelType::u8;
  write_file(folder / "w.rec", std::string(1024, '\0'));
  EXPECT_EQ(open(folder / "w.rec", raw).source->header().format, "raw");
}

TEST(ImportMrc, AWrongMachineStampIsNoted) {
  const TempFolder folder;
  MrcFile file;
  file.text(54, "\x11\x11");
  write_file(folder / "v.mrc", file.bytes());
  auto volume = open(folder / "v.mrc");
  EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize));
  expect_note(volume, "machine stamp");
}

TEST(ImportMrc, KeepsTheAxesOfTheCell) {
  const TempFolder folder;
  MrcFile file;  // columns are z, rows x, sections y: of 3, 5 and 4 voxels of the cell
  file.set(17, int32_t{3}).set(18, int32_t{1}).set(19, int32_t{2});
  file.set(5, int32_t{7});
  write_file(folder / "v.map", file.bytes());
  const VolumeGrid grid = header_of(folder / "v.map").grid;
  const Vec3d first = grid.world({0, 0, 0}), next = grid.world({1, 0, 0});
  EXPECT_NEAR(first.z, 7 * 5e-7, 1e-14) << "NXSTART counts columns";
  EXPECT_NEAR(next.z - first.z, 5e-7, 1e-14) << "columns lie along z";
  const Vec3d row = grid.world({0, 1, 0}), section = grid.world({0, 0, 1});
  EXPECT_NEAR(row.x - first.x, 2e-7, 1e-14);
  EXPECT_NEAR(section.y - first.y, 3e-7, 1e-14);
}

TEST(ImportMrc, AxesWithoutValuesAreNoted) {
  const TempFolder folder;
  MrcFile file;
  for (size_t word = 14; word < 20; ++word) file.set(word, int32_t{0});
  file.set(11, 0.0f);
  write_file(folder / "v.mrc", file.bytes());
  const OpenVolume volume = open(folder / "v.mrc");
  expect_note(volume, "right angles are assumed");
  expect_note(volume, "x, y and z are assumed");
  expect_note(volume, "1,1,1 is assumed");
  EXPECT_EQ(volume.source->header().grid.spacing, (Vec3d{1, 1, 1}));
}

TEST(ImportMrc, ImagesBecomeSlicesWithANote) {
  const TempFolder folder;
  MrcFile file;
  file.set(10, int32_t{1}).set(23, int32_t{0});
  write_file(folder / "v.st", file.bytes());
  expect_note(open(folder / "v.st"), "separate images");
}

TEST(ImportMrc, ChoosesOneOfSeveralVolumes) {
  const TempFolder folder;
  MrcFile file;
  file.set(3, int32_t{6}).set(23, int32_t{401});
  file.voxels = std::string(120, '\0') + file.voxels;
  write_file(folder / "v.mrc", file.bytes());
  expect_error(folder / "v.mrc", "found 2 time steps");
  ImportOptions options;
  options.time_step = 1;
  EXPECT_EQ(read_all(*open(folder / "v.mrc", options).source), pattern_voxels<double>(kSize));
  file.set(10, int32_t{4});
  write_file(folder / "v.mrc", file.bytes());
  expect_error(folder / "v.mrc", "MZ 4", options);
}

TEST(ImportMrc, Errors) {
  const TempFolder folder;
  const auto expect = [&](const MrcFile& file, const std::string& part) {
    write_file(folder / "v.mrc", file.bytes());
    expect_error(folder / "v.mrc", part);
  };
  expect(MrcFile().set(4, int32_t{4}), "found 2 (colours or vectors)");
  expect(MrcFile().set(4, int32_t{16}), "found 3 (colours or vectors)");
  expect(MrcFile().set(4, int32_t{5}), "no known signature");
  expect(MrcFile().set(4, int32_t{77}), "no known signature");
  expect(MrcFile().set(18, int32_t{1}), "found 1, 1 and 3");
  expect(MrcFile().set(24, int32_t{-4}), "(NSYMBT) of 0 bytes or more, found -4");
  expect(MrcFile().set(24, int32_t{0x7fffffff}), "found 0");
  expect(MrcFile().set(14, 200.0f), "expected the angles of a cell");
  expect(MrcFile().set(14, 10.0f).set(15, 10.0f).set(16, 90.0f), "expected the angles of a cell");
  expect(MrcFile().set(14, NAN), "expected the angles of a cell");
  expect(MrcFile().set(1, int32_t{-5}), "at least 2 voxels along each axis");
  expect(MrcFile().set(3, int32_t{1}), "single slice");
  expect(MrcFile().set(1, int32_t{0x7fffffff}).set(2, int32_t{0x7fffffff}), "at most");
  MrcFile more;
  more.voxels += "xx";
  expect(more, "2 more");
  write_file(folder / "cut.mrc", MrcFile().bytes().substr(0, 1000));
  expect_error(folder / "cut.mrc", "no known signature");
  ImportOptions options;
  options.time_step = 1;
  write_file(folder / "v.mrc", MrcFile().bytes());
  expect_error(folder / "v.mrc", "--time-step from 0 to 0", options);
}

}  // namespace
}  // namespace isosplat::import
