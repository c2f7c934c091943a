#include "tests/native/import_checks.h"

namespace isosplat::import {
namespace {

using test::byte_swapped;
using test::bytes_of;
using test::expect_error;
using test::expect_note;
using test::open;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

/// A file of NumPy with this dictionary and these bytes of voxels.
std::string npy(const std::string& dictionary, const std::string& voxels, int version = 1) {
  std::string file = "\x93NUMPY";
  file += {static_cast<char>(version), '\0'};
  const size_t bytes = dictionary.size() + 1;
  for (int i = 0; i < (version > 1 ? 4 : 2); ++i) file += static_cast<char>(bytes >> 8 * i);
  return file + dictionary + "\n" + voxels;
}

std::string dictionary(const std::string& type, const std::string& shape = "(3, 4, 5)",
                       const std::string& order = "False") {
  return fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}", type, order, shape);
}

TEST(ImportNpy, ReadsEveryTypeInBothByteOrders) {
  const TempFolder folder;
  const auto check = [&]<class T>(T, const std::string& kind, VoxelType type) {
    for (const bool big : {false, true}) {
      auto voxels = pattern_voxels<T>(kSize, sizeof(T) == 1 ? 0.5 : 1);
      std::vector<double> expected;
      for (const T v : voxels) expected.push_back(static_cast<double>(v));
      if (big != (std::endian::native == std::endian::big)) voxels = byte_swapped(voxels);
      const std::string order = sizeof(T) == 1 ? "|" : big ? ">" : "<";
      for (int version = 1; version <= 3; ++version) {
        write_file(folder / "v.npy", npy(dictionary(order + kind), bytes_of(voxels), version));
        auto volume = open(folder / "v.npy");
        ASSERT_TRUE(volume.source);
        EXPECT_EQ(volume.source->header().format, "NumPy");
        EXPECT_EQ(volume.source->header().type, type) << kind;
        EXPECT_EQ(volume.source->header().grid.voxels, kSize);
        EXPECT_EQ(read_all(*volume.source), expected) << order << kind;
      }
    }
  };
  check(uint8_t{}, "u1", VoxelType::u8);
  check(int8_t{}, "i1", VoxelType::i8);
  check(uint8_t{}, "b1", VoxelType::u8);
  check(uint16_t{}, "u2", VoxelType::u16);
  check(int16_t{}, "i2", VoxelType::i16);
  check(uint32_t{}, "u4", VoxelType::u32);
  check(int32_t{}, "i4", VoxelType::i32);
  check(uint64_t{}, "u8", VoxelType::u64);
  check(int64_t{}, "i8", VoxelType::i64);
  check(float{}, "f4", VoxelType::f32);
  check(double{}, "f8", VoxelType::f64);
}

TEST(ImportNpy, ReadsHalfFloats) {
  const TempFolder folder;
  std::vector<uint16_t> halves(60, 0x3c00);  // 1
  halves[7] = 0xc500;                        // −5
  for (const bool big : {false, true}) {
    write_file(folder / "v.npy",
               npy(dictionary(big ? ">f2" : "<f2"), bytes_of(big ? byte_swapped(halves) : halves)));
    auto volume = open(folder / "v.npy");
    EXPECT_EQ(volume.source->header().type, VoxelType::f32);
    const auto values = read_all(*volume.source);
    EXPECT_EQ(values[6], 1);
    EXPECT_EQ(values[7], -5);
  }
}

TEST(ImportNpy, TheSameArrayInBothOrdersIsTheSameVolume) {
  const TempFolder folder;
  std::vector<int16_t> fortran;
  for (int x = 0; x < 5; ++x) {
    for (int y = 0; y < 4; ++y) {
      for (int z = 0; z < 3; ++z) {
        fortran.push_back(static_cast<int16_t>(test::pattern(x, y, z)));
      }
    }
  }
  write_file(folder / "v.npy", npy(dictionary("<i2", "(3, 4, 5)", "True"), bytes_of(fortran)));
  ImportOptions options;
  options.spacing = Vec3d{2, 3, 7};
  auto volume = open(folder / "v.npy", options);
  expect_note(volume, "z, y and x");
  const VolumeGrid& grid = volume.source->header().grid;
  EXPECT_EQ(grid.voxels, (Index3{3, 4, 5}));
  const auto values = read_all(*volume.source);
  size_t i = 0;
  for (int c = 0; c < 5; ++c) {
    for (int b = 0; b < 4; ++b) {
      for (int a = 0; a < 3; ++a) {
        const Vec3d at = grid.world({double(a), double(b), double(c)});
        EXPECT_EQ(values[i++], test::pattern(std::lround(at.x / 2), std::lround(at.y / 3),
                                             std::lround(at.z / 7)));
      }
    }
  }
}

TEST(ImportNpy, LeavesOutAxesOfOneSample) {
  const TempFolder folder;
  const std::string voxels = bytes_of(pattern_voxels<int16_t>(kSize));
  for (const char* shape :
       {"(1, 1, 3, 4, 5)", "(1L, 3L, 4L, 5L)", "(3,4,5)", "(3, 4, 5, 1)", "(3, 1, 4, 1, 5)"}) {
    write_file(folder / "v.npy", npy(dictionary("<i2", shape), voxels));
    EXPECT_EQ(read_all(*open(folder / "v.npy").source), pattern_voxels<double>(kSize)) << shape;
  }
}

TEST(ImportNpy, HeadersAreParsedStrictly) {
  const TempFolder folder;
  const std::string voxels = bytes_of(pattern_voxels<int16_t>(kSize));
  const auto expect = [&](const std::string& text, const std::string& part) {
    SCOPED_TRACE(text);
    write_file(folder / "v.npy", npy(text, voxels));
    expect_error(folder / "v.npy", part);
  };
  const std::string type = "'descr': '<i2'", order = "'fortran_order': False",
                    shape = "'shape': (3, 4, 5)";
  write_file(folder / "v.npy",
             npy("{\"shape\": (3, 4, 5), " + order + "," + type + "}     ", voxels));
  EXPECT_EQ(read_all(*open(folder / "v.npy").source), pattern_voxels<double>(kSize));
  expect("", "expected a dictionary in the header, found the end");
  expect("[1]", "expected a dictionary in the header, found '[1]'");
  expect("{" + type + ", " + order + "}", "found fewer");
  expect("{" + type + ", " + order + ", " + shape + ", " + type + "}", "once each");
  expect("{" + type + ", " + order + ", " + shape + ", 'more': 1}", "once each");
  expect("{" + type + " " + order + ", " + shape + "}", "expected a comma");
  expect("{" + type + ", " + order + ", " + shape, "expected a comma in the header, found the end");
  expect("{" + type + ", " + order + ", " + shape + "} + 1", "expected the end");
  expect("{" + type + ", 'fortran_order': 0, " + shape + "}", "True or False");
  expect("{" + type + ", 'fortran_order': Falsehood, " + shape + "}", "expected a comma");
  expect("{descr: '<i2'}", "expected a key");
  expect("{'descr' '<i2'}", "expected a colon");
  expect("{'descr': i2}", "expected a type");
  expect("{'descr': '<i2", "expected a type");
  expect("{'descr': '<\\x692'}", "expected a type");
  expect(dictionary("<i2\x1b[31m"), "expected a type");
  expect(dictionary(std::string(41, 'i')), "expected a type");
  for (const char* sizes : {"(3, 4, -5)", "(3 4 5)", "[3, 4, 5]", "(3, 4, 5", "(3, , 4)", "(60)",
                            "(3, 4, 99999999999999999999)", "(3.0, 4, 5)"}) {
    expect(dictionary("<i2", sizes), "expected a tuple of sizes");
  }
}

/// The array (step, z, y, x) in the order of the axes of `shape`, as C or Fortran has it.
std::string stacked(bool step_last, bool fortran_order, int steps) {
  std::vector<int16_t> values;
  const bool is_fastest = step_last != fortran_order;
  const auto at = [&](int i, int step) {
    int x = i % 5, y = i / 5 % 4, z = i / 20;
    if (fortran_order) z = i % 3, y = i / 3 % 4, x = i / 12;
    return static_cast<int16_t>(test::pattern(x, y, z) + 1000 * step);
  };
  for (int n = 0; n < 60 * steps; ++n) {
    values.push_back(is_fastest ? at(n / steps, n % steps) : at(n % 60, n / 60));
  }
  return bytes_of(values);
}

TEST(ImportNpy, FourthAxesAreTimesOrChannels) {
  const TempFolder folder;
  const auto path = folder / "v.npy";
  for (const bool fortran : {false, true}) {
    const std::string order = fortran ? "True" : "False";
    const auto expect_step = [&](const ImportOptions& options, int step) {
      const auto volume = open(path, options);
      ASSERT_TRUE(volume.source);
      const VolumeGrid& grid = volume.source->header().grid;
      const auto values = read_all(*volume.source);
      size_t i = 0, wrong = 0;
      for (int c = 0; c < grid.voxels.z; ++c) {
        for (int b = 0; b < grid.voxels.y; ++b) {
          for (int a = 0; a < grid.voxels.x; ++a) {
            const Vec3d p = grid.world({double(a), double(b), double(c)});
            wrong +=
                values[i++] !=
                test::pattern(std::lround(p.x), std::lround(p.y), std::lround(p.z)) + 1000 * step;
          }
        }
      }
      EXPECT_EQ(wrong, 0u) << fortran << step;
    };
    ImportOptions step, channel, both;
    step.time_step = both.time_step = 1;
    channel.channel = both.channel = 1;
    // The first axis is time, or channels if one is chosen.
    write_file(path, npy(dictionary("<i2", "(6, 3, 4, 5)", order), stacked(false, fortran, 6)));
    expect_error(path, "expected one volume, found 6 time steps: choose one with --time-step 0");
    EXPECT_EQ(test::offered_choices(path).size(), 6u);
    EXPECT_EQ(test::offered_choices(path)[5].time_step, 5);
    expect_step(step, 1);
    expect_note(open(path, step), "the first one is read as time steps of 6");
    expect_step(channel, 1);
    expect_note(open(path, channel), "the first one is read as channels of 6");
    expect_error(path, "--channel from 0 to 0, found 1", both);
    // A short last axis is that of colours.
    write_file(path, npy(dictionary("<i2", "(3, 4, 5, 2)", order), stacked(true, fortran, 2)));
    expect_error(path,
                 "whose first and last axis may be that: choose along the first with "
                 "--time-step 0 to --time-step 2, or along the last with --channel 0");
    expect_step(channel, 1);
    expect_note(open(path, channel), "the last one is read as channels of 2");
    write_file(path, npy(dictionary("<i2", "(5, 3, 4, 2)", order), std::string(240, 'x')));
    expect_error(path, "expected one number per voxel, found 2 channels: choose one");
    EXPECT_EQ(test::offered_choices(path)[1].channel, 1);
  }
  ImportOptions channel;
  channel.channel = 1;
  write_file(path, npy(dictionary("<i2"), bytes_of(pattern_voxels<int16_t>(kSize))));
  expect_error(path, "--channel from 0 to 0, found 1", channel);
}

TEST(ImportNpy, RowsOfManyStepsAreRefused) {
  const TempFolder folder;
  const std::string voxels = bytes_of(pattern_voxels<int16_t>(kSize));
  write_file(folder / "v.npy",
             npy("{'descr': '<i2', 'fortran_order': True, 'shape': (70000, 20000, 5, 5)}", voxels));
  ImportOptions step;
  step.time_step = 0;
  expect_error(folder / "v.npy",
               "expected rows of at most 1073741824 bytes with all their steps, found 2800000000",
               step);
}

TEST(ImportNpy, Errors) {
  const TempFolder folder;
  const std::string voxels = bytes_of(pattern_voxels<int16_t>(kSize));
  const auto expect = [&](const std::string& file, const std::string& part) {
    write_file(folder / "v.npy", file);
    expect_error(folder / "v.npy", part);
  };
  for (const char* type : {"i2", "=i2", "|i2", "<i3", "<f16", "|O", "<U3", "<M8[ns]", ""}) {
    expect(npy(dictionary(type), voxels), fmt::format("found NumPy's type '{}'", type));
  }
  expect(npy(dictionary("<c8"), voxels), "found 2 (colours or vectors)");
  expect(npy("{'descr': [('a', '<i2')], 'fortran_order': False, 'shape': (3, 4, 5)}", voxels),
         "array of records");
  expect(npy(dictionary("<i2", "()"), voxels), "found the shape ()");
  expect(npy(dictionary("<i2", "(60,)"), voxels), "found the shape (60)");
  expect(npy(dictionary("<i2", "(0, 3, 4, 5)"), voxels), "found the shape (0, 3, 4, 5)");
  expect(npy(dictionary("<i2", "(3, 4, 5, 0)"), voxels), "found the shape (3, 4, 5, 0)");
  // The advice leads to an array with three axes.
  const auto expect_advice = [&](const std::string& shape, const std::string& index) {
    expect(npy(dictionary("<i2", shape), voxels),
           "numpy.save('volume.npy', numpy.load(sys.argv[1])[" + index + "])\" " +
               (folder / "v.npy").string());
  };
  expect_advice("(2, 3, 6, 7, 8)", "0, 0");
  expect_advice("(1, 2, 1, 3, 6, 7, 8)", "0, 0, 0, 0");
  expect_advice("(2, 6, 7, 8, 2)", "0, ..., 0");
  expect(npy(dictionary("<i2", "(3, 0, 5)"), voxels), "at least 2 voxels");
  expect(npy(dictionary("<i2", "(1, 12, 5)"), voxels), "found the shape (1, 12, 5)");
  expect(npy(dictionary("<i2", "(4000000000, 4000000000, 4000000000)"), voxels), "at most");
  expect(npy(dictionary("<i2"), voxels.substr(1)), "expected 120 bytes of voxels");
  expect(npy(dictionary("<i2"), voxels + "x"), "1 more");
  expect(npy(dictionary("<i2"), voxels, 4), "found 4.0");
  expect(npy(dictionary("<i2"), "").substr(0, 40), "expected at least");
  expect("\x93NUMPY", "expected at least 12 bytes");
  expect(npy(dictionary("<i2") + std::string(20'000, ' '), voxels), "at most 10000 bytes");
  ImportOptions options;
  options.time_step = 2;
  write_file(folder / "v.npy", npy(dictionary("<i2"), voxels));
  expect_error(folder / "v.npy", "--time-step from 0 to 0", options);
}

}  // namespace
}  // namespace isosplat::import
