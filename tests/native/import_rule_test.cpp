#include <tiffio.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "tests/native/import_checks.h"

// The rule: the result is the right volume, the right volume with a note, or an error. These are
// cases that earlier versions read wrongly. The conformance suite tests the rule on many generated
// files.
namespace isosplat::import {
namespace {

using test::bytes_of;
using test::error_of;
using test::expect_error;
using test::expect_note;
using test::nrrd_header;
using test::open;
using test::pattern;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

/// Expects that voxel (x, y, z) of the file has the pattern's value and is at `position(x, y, z)`.
template <class Position>
void expect_positions(OpenVolume& volume, Position position) {
  ASSERT_TRUE(volume.source);
  const VolumeGrid& grid = volume.source->header().grid;
  ASSERT_EQ(grid.voxels, kSize);
  const auto values = read_all(*volume.source);
  for (int z = 0; z < 3; ++z) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 5; ++x) {
        bool found = false;
        for (int j = 0; j < 4; ++j) {  // rows may be reversed
          if (length(grid.world({double(x), double(j), double(z)}) - position(x, y, z)) > 1e-6)
            continue;
          found = true;
          EXPECT_EQ(values[static_cast<size_t>((z * 4 + j) * 5 + x)], pattern(x, y, z));
        }
        EXPECT_TRUE(found) << x << ' ' << y << ' ' << z;
      }
    }
  }
}

std::string voxels() {
  return bytes_of(pattern_voxels<int16_t>(kSize));
}

ImportOptions allowing(Allowance allowance) {
  ImportOptions options;
  options.allowed.add(allowance);
  return options;
}

// NRRD --------------------------------------------------------------------------------------------

TEST(RuleNrrd, LeftAnteriorSuperiorIsNotRotated) {
  const TempFolder folder;
  for (const char* space : {"left-anterior-superior", "LAS"}) {
    write_file(
        folder / "v.nrrd",
        nrrd_header(kSize, "short",
                    fmt::format("space: {}\nspace directions: (1,0,0) (0,2,0) (0,0,3)\n"
                                "space origin: (10,20,30)\nendian: little\nencoding: raw\n\n",
                                space)) +
            voxels());
    auto volume = open(folder / "v.nrrd");
    expect_positions(volume, [](int x, int y, int z) {
      return Vec3d{10.0 + x, -(20.0 + 2 * y), 30.0 + 3 * z};
    });
  }
}

TEST(RuleNrrd, AListOrTimeAxisIsFoundInAnyPosition) {
  const TempFolder folder;
  for (const char* kind : {"list", "time"}) {
    for (const int place : {0, 1, 2, 3}) {
      std::vector<int16_t> stored;
      const int sizes[] = {5, 4, 3};
      std::array<int, 4> all{};
      for (int i = 0, s = 0; i < 4; ++i) all[i] = i == place ? 2 : sizes[s++];
      for (int n = 0; n < 120; ++n) {
        int rest = n, at[4];
        for (int i = 0; i < 4; ++i) at[i] = rest % all[i], rest /= all[i];
        std::vector<int> space;
        for (int i = 0; i < 4; ++i) {
          if (i != place) space.push_back(at[i]);
        }
        stored.push_back(
            static_cast<int16_t>(at[place] == 1 ? pattern(space[0], space[1], space[2]) : -1));
      }
      std::string kinds = "kinds:", directions = "space directions:";
      const char* vectors[] = {"(1,0,0)", "(0,1,0)", "(0,0,1)"};
      for (int i = 0, s = 0; i < 4; ++i) {
        kinds += i == place ? std::string(" ") + kind : " domain";
        directions += i == place ? " none" : std::string(" ") + vectors[s++];
      }
      SCOPED_TRACE(kinds);
      for (const bool with_space : {false, true}) {
        write_file(folder / "v.nrrd",
                   fmt::format("NRRD0005\ntype: short\ndimension: 4\nsizes: {} {} {} {}\n{}\n{}"
                               "endian: little\nencoding: raw\n\n",
                               all[0], all[1], all[2], all[3], kinds,
                               with_space ? "space dimension: 3\n" + directions + "\n" : "") +
                       bytes_of(stored));
        expect_error(folder / "v.nrrd", "--time-step 0 to --time-step 1");
        ImportOptions options;
        options.time_step = 1;
        auto volume = open(folder / "v.nrrd", options);
        expect_positions(volume, [](int x, int y, int z) {
          return Vec3d{double(x), double(y), double(z)};
        });
      }
    }
  }
}

TEST(RuleNrrd, FlatColoursVectorsAndFlatListsAreErrors) {
  const TempFolder folder;
  const auto header = [](const char* sizes, const char* kinds) {
    return fmt::format(
        "NRRD0005\ntype: uchar\ndimension: {}\nsizes: {}\nkinds: {}\nencoding: raw\n\n",
        std::count(sizes, sizes + std::strlen(sizes), ' ') + 1, sizes, kinds);
  };
  write_file(folder / "rgb.nrrd",
             header("3 5 4", "RGB-color domain domain") + std::string(60, 'x'));
  expect_error(folder / "rgb.nrrd", "found an image with 2");
  write_file(folder / "last.nrrd",
             header("5 4 3 3", "domain domain domain vector") + std::string(180, 'x'));
  expect_error(folder / "last.nrrd",
               "found 3 channels: choose one with --channel 0 to --channel 2");
  write_file(folder / "list.nrrd", header("5 4 3", "list domain domain") + std::string(60, 'x'));
  expect_error(folder / "list.nrrd", "three spatial axes");
}

TEST(RuleNrrd, AxisMinsMaxsAndNegativeSpacings) {
  const TempFolder folder;
  const auto header = [](const std::string& lines) {
    return nrrd_header(kSize, "short", lines + "endian: little\nencoding: raw\n\n");
  };
  write_file(folder / "node.nrrd", header("axis mins: 1 2 3\naxis maxs: 5 8 4\n"
                                          "centers: node node node\n") +
                                       voxels());
  auto node = open(folder / "node.nrrd");
  expect_positions(node, [](int x, int y, int z) {
    return Vec3d{1.0 + x, 2.0 + 2 * y, 3.0 + 0.5 * z};
  });
  EXPECT_TRUE(node.notes.empty());
  write_file(folder / "cell.nrrd", header("axis mins: 0 0 0\naxis maxs: 10 8 9\n"
                                          "centerings: cell cell cell\n") +
                                       voxels());
  auto cell = open(folder / "cell.nrrd");
  expect_positions(cell, [](int x, int y, int z) {
    return Vec3d{1.0 + 2 * x, 1.0 + 2 * y, 1.5 + 3 * z};
  });
  write_file(folder / "negative.nrrd", header("spacings: 1 -2 3\n") + voxels());
  auto negative = open(folder / "negative.nrrd");
  expect_note(negative, "is negative: the axis is reversed");
  expect_positions(negative, [](int x, int y, int z) {
    return Vec3d{double(x), -2.0 * y, 3.0 * z};
  });
}

// MetaImage ---------------------------------------------------------------------------------------

constexpr const char* kMeta =
    "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementSpacing = 1 1 1\n"
    "ElementType = MET_SHORT\n";

TEST(RuleMetaImage, MissingAndShortSlicesAreErrorsUnlessAllowed) {
  const TempFolder folder;
  for (const char* data : {"LIST\ns1\ns2\ns3\n", "s%d 1 3 1\n"}) {
    SCOPED_TRACE(data);
    write_file(folder / "v.mhd", std::string(kMeta) + "ElementDataFile = " + data);
    for (int z = 0; z < 3; ++z) {
      write_file(folder / fmt::format("s{}", z + 1), voxels().substr(z * 40, 40));
    }
    auto whole = open(folder / "v.mhd");
    EXPECT_EQ(read_all(*whole.source), pattern_voxels<double>(kSize));
    EXPECT_EQ(whole.source->resident_bytes(), 0u);

    write_file(folder / "s2", voxels().substr(40, 38));
    expect_error(folder / "v.mhd", "expected 40 bytes of voxels, found 38");
    expect_note(open(folder / "v.mhd", allowing(Allowance::truncated)), "found 38");
    std::filesystem::remove(folder / "s2");
    expect_error(folder / "v.mhd", "--allow-gaps");
    auto gap = open(folder / "v.mhd", allowing(Allowance::gaps));
    expect_note(gap, "1 of the 3 data files");
    // The values in between are unknown. They must not be invented, and all others stay unchanged.
    const auto expected = pattern_voxels<double>(kSize), found = read_all(*gap.source);
    EXPECT_EQ(gap.source->header().type, VoxelType::f32);
    for (size_t i = 0; i < 60; ++i) {
      EXPECT_TRUE(i / 20 == 1 ? std::isnan(found[i]) : found[i] == expected[i]) << i;
    }
    write_file(folder / "s2", voxels().substr(40, 40) + "more");
    expect_error(folder / "v.mhd", "--allow-surplus");
  }
}

TEST(RuleMetaImage, WordsThatAreNotNumbersAreErrors) {
  const TempFolder folder;
  const auto write = [&](const char* type, const std::string& word) {
    std::string text;
    for (int i = 0; i < 60; ++i) text += i == 33 ? word + " " : fmt::format("{} ", i);
    write_file(
        folder / "v.mha",
        fmt::format("ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementSpacing = 1 1 1\n"
                    "BinaryData = False\nElementType = {}\nElementDataFile = LOCAL\n{}",
                    type, text));
  };
  write("MET_SHORT", "12");
  EXPECT_EQ(error_of(folder / "v.mha"), "");
  for (const char* word : {"abc", "nan", "1.5", "70000", "12x", "--3", "0x1f"}) {
    write("MET_SHORT", word);
    expect_error(folder / "v.mha", fmt::format("value 34, found '{}'", word));
  }
  write("MET_FLOAT", "nan");  // an absent voxel
  auto floats = open(folder / "v.mha");
  const auto values = read_all(*floats.source);
  EXPECT_TRUE(std::isnan(values[33]));
  EXPECT_EQ(values[34], 34);
  write("MET_FLOAT", "1.5e");
  expect_error(folder / "v.mha", "value 34, found '1.5e'");
}

// TIFF --------------------------------------------------------------------------------------------

struct TiffOptions {
  int pages = 3, bits = 16, format = SAMPLEFORMAT_UINT;
  uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  std::string description = {};
};

void write_tiff(const std::filesystem::path& path, const std::string& data,
                const TiffOptions& options) {
  TIFF* tiff = TIFFOpen(path.c_str(), "wl");
  ASSERT_TRUE(tiff);
  const size_t row = static_cast<size_t>(5 * options.bits / 8);
  for (int page = 0; page < options.pages; ++page) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 5);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 4);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, options.bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, options.format);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, options.photometric);
    if (!options.description.empty() && page == 0) {
      TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, options.description.c_str());
    }
    for (uint32_t y = 0; y < 4; ++y) {
      std::string line = data.substr((static_cast<size_t>(page) * 4 + y) * row, row);
      TIFFWriteScanline(tiff, line.data(), y);
    }
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
}

TEST(RuleTiff, AMissingPageIsAnErrorUnlessAllowed) {
  const TempFolder folder;
  write_tiff(folder / "v.tif", voxels(), {});
  const std::string whole = test::read_file(folder / "v.tif");
  for (size_t cut = 1; cut < whole.size() - 8; cut += 7) {
    write_file(folder / "v.tif", whole.substr(0, whole.size() - cut));
    EXPECT_NE(error_of(folder / "v.tif"), "") << cut;
  }
  write_file(folder / "v.tif", whole.substr(0, whole.size() - 150));
  expect_error(folder / "v.tif", "--allow-truncated");
  expect_note(open(folder / "v.tif", allowing(Allowance::truncated)), "before its last page");
}

TEST(RuleTiff, HyperstacksAreNotTallStacks) {
  const TempFolder folder;
  TiffOptions options;
  options.pages = 6;
  options.description =
      "ImageJ=1.53t\nimages=6\nslices=3\nframes=2\nhyperstack=true\nunit=mm\n"
      "spacing=2.0\n";
  write_tiff(folder / "v.tif", bytes_of(std::vector<int16_t>(60, 7)) + voxels(), options);
  expect_error(folder / "v.tif", "2 time steps");
  ImportOptions second;
  second.time_step = 1;
  auto volume = open(folder / "v.tif", second);
  EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize));
  options.description = "ImageJ=1.53t\nimages=6\nchannels=2\nslices=3\n";
  write_tiff(folder / "c.tif", voxels() + voxels(), options);
  expect_error(folder / "c.tif", "found 2 channels: choose one with --channel 0 to --channel 1");
  options.description = "ImageJ=1.53t\nimages=9\nslices=9\n";
  write_tiff(folder / "s.tif", voxels() + voxels(), options);
  expect_error(folder / "s.tif", "expected 9 pages");
}

TEST(RuleTiff, FoldersOfStacksAndAmbiguousNamesAreErrors) {
  const auto one_page = [](const TempFolder& folder, const std::string& name, int z) {
    TiffOptions page;
    page.pages = 1;
    write_tiff(folder / name, voxels().substr(z * 40, 40), page);
  };
  {
    const TempFolder folder;
    write_tiff(folder / "a1.tif", voxels(), {});
    write_tiff(folder / "a2.tif", voxels(), {});
    expect_error(folder.path(), "expected one page in each file of a folder, found 3");
  }
  const std::vector<std::vector<std::string>> ordered = {
      {"z-5.tif", "z0.tif", "z5.tif"},       {"z0.5.tif", "z1.0.tif", "z1.5.tif"},
      {"a-1.tif", "a-2.tif", "a-3.tif"},     {"z8.tif", "z9.tif", "z10.tif"},
      {"z-0.5.tif", "z0.0.tif", "z0.5.tif"}, {"s1_z08.tif", "s1_z09.tif", "s1_z10.tif"}};
  for (const auto& names : ordered) {
    const TempFolder folder;
    for (int z = 0; z < 3; ++z) one_page(folder, names[static_cast<size_t>(z)], z);
    auto volume = open(folder.path());
    ASSERT_TRUE(volume.source) << names[0];
    EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize)) << names[0];
  }
  const std::vector<std::pair<std::vector<std::string>, std::string>> ambiguous = {
      {{"t1z1.tif", "t1z2.tif", "t2z1.tif", "t2z2.tif"}, "vary independently"},
      {{"a1.tif", "a2.tif", "b1.tif"}, "2 different patterns"},
      {{"z1.5.tif", "z1.25.tif", "z2.0.tif", "z0.75.tif"}, "are decimals"},
      {{"a1b2.tif", "a2b1.tif"}, "give different orders"},
      {{"z1.tif", "z2.tif", "z4.tif"}, "--allow-gaps"}};
  for (const auto& [names, part] : ambiguous) {
    const TempFolder folder;
    for (const std::string& name : names) one_page(folder, name, 0);
    expect_error(folder.path(), part);
  }
  const TempFolder folder;
  for (const int z : {1, 2, 4}) one_page(folder, fmt::format("z{}.tif", z), z % 3);
  auto filled = open(folder.path(), allowing(Allowance::gaps));
  EXPECT_EQ(filled.source->header().grid.voxels.z, 4);
  const auto values = read_all(*filled.source);
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(std::isnan(values[i]), i / 20 == 2) << i;
  expect_note(filled, "1 slices are missing");
}

TEST(RuleTiff, ZeroAsWhiteLeavesFloatsAlone) {
  const TempFolder folder;
  TiffOptions options;
  options.bits = 32;
  options.format = SAMPLEFORMAT_IEEEFP;
  options.photometric = PHOTOMETRIC_MINISWHITE;
  write_tiff(folder / "v.tif", bytes_of(pattern_voxels<float>(kSize, 0.5)), options);
  auto volume = open(folder / "v.tif");
  EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize, 0.5));
  expect_note(volume, "0 as white");
}

// VTK ---------------------------------------------------------------------------------------------

TEST(RuleVtk, CellDataIsNotReadAsPointData) {
  const TempFolder folder;
  const std::string head =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS {} {} {}\n"
      "SPACING 1 2 3\nORIGIN 10 20 30\n";
  std::string points, cells;
  for (const int v : pattern_voxels<int>(kSize)) points += fmt::format("{} ", v);
  for (int i = 0; i < 24; ++i) cells += "-7 ";
  write_file(folder / "both.vtk",
             fmt::format(fmt::runtime(head), 5, 4, 3) +
                 "CELL_DATA 24\nSCALARS c short\nLOOKUP_TABLE default\n" + cells +
                 "\nPOINT_DATA 60\nSCALARS p short\nLOOKUP_TABLE default\n" + points + "\n");
  auto both = open(folder / "both.vtk");
  EXPECT_EQ(read_all(*both.source), pattern_voxels<double>(kSize));
  expect_note(both, "'p' of its points is read");
  // Values that exist only for cells become voxels at the cells' centres.
  write_file(folder / "cells.vtk", fmt::format(fmt::runtime(head), 6, 5, 4) +
                                       "CELL_DATA 60\nSCALARS c short\nLOOKUP_TABLE default\n" +
                                       points + "\n");
  auto only = open(folder / "cells.vtk");
  expect_note(only, "cell's centre");
  expect_positions(only, [](int x, int y, int z) {
    return Vec3d{10.5 + x, 21.0 + 2 * y, 31.5 + 3 * z};
  });
  write_file(folder / "wrong.vtk", fmt::format(fmt::runtime(head), 5, 4, 3) +
                                       "POINT_DATA 24\nSCALARS c short\nLOOKUP_TABLE default\n" +
                                       points + "\n");
  expect_error(folder / "wrong.vtk", "expected 60 values");
}

TEST(RuleVtk, WordsThatAreNotNumbersAndShortTextAreErrors) {
  const TempFolder folder;
  const auto write = [&](int count, const std::string& word) {
    std::string text;
    for (int i = 0; i < count; ++i) text += i == 33 ? word + " " : fmt::format("{} ", i);
    write_file(folder / "v.vtk",
               "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\n"
               "DIMENSIONS 5 4 3\nSPACING 1 2 3\nORIGIN 0 0 0\nPOINT_DATA 60\n"
               "SCALARS p short\nLOOKUP_TABLE default\n" +
                   text + "\n");
  };
  write(60, "12");
  EXPECT_EQ(error_of(folder / "v.vtk"), "");
  for (const char* word : {"abc", "nan", "1.5", "70000", "12x"}) {
    write(60, word);
    expect_error(folder / "v.vtk", fmt::format("value 34, found '{}'", word));
  }
  write(59, "12");
  EXPECT_NE(error_of(folder / "v.vtk"), "");
}

// NIfTI -------------------------------------------------------------------------------------------

test::NiftiFile nifti() {
  test::NiftiFile file;
  file.sizes = {5, 4, 3};
  file.rows = {{{2, 0, 0, 10}, {0, 3, 0, 20}, {0, 0, 4, 30}}};
  file.voxels = voxels();
  return file;
}

TEST(RuleNifti, MicrometresScaleTheOriginAsWell) {
  const TempFolder folder;
  std::string bytes = nifti().bytes();
  bytes[123] = 3;
  write_file(folder / "v.nii", bytes);
  auto volume = open(folder / "v.nii");
  expect_positions(volume, [](int x, int y, int z) {
    return Vec3d{-(10.0 + 2 * x), -(20.0 + 3 * y), 30.0 + 4 * z} * 1e-3;
  });
}

TEST(RuleNifti, ATimeOfNoStepsIsOneStepWithANote) {
  const TempFolder folder;
  auto file = nifti();
  file.sizes = {5, 4, 3, 0};
  write_file(folder / "v.nii", file.bytes());
  auto volume = open(folder / "v.nii");
  EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize));
  expect_note(volume, "dimension 4 is 0");
  file.sizes = {5, 4, 0};
  write_file(folder / "v.nii", file.bytes());
  expect_error(folder / "v.nii", "found 0 along dimension 3");
}

TEST(RuleNifti, CompressedDataIsDetectedWithAnyName) {
  const TempFolder folder;
  for (const char* name : {"v.nii", "v.img.copy", "v.gz"}) {
    write_file(folder / name, test::deflated(nifti().bytes()));
    auto volume = open(folder / name);
    ASSERT_TRUE(volume.source);
    EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize));
  }
}

// Every format ------------------------------------------------------------------------------------

TEST(RuleChanges, AVolumeThatChangesWhileItIsReadIsAnError) {
  const TempFolder folder;
  const std::string header =
      nrrd_header(kSize, "short", "spacings: 1 1 1\nendian: little\nencoding: raw\n");
  const std::string other = bytes_of(pattern_voxels<int16_t>(kSize, -1));
  std::vector<std::byte> slice(40);
  const auto open_first = [&](const std::filesystem::path& path) {
    auto volume = open(path);
    EXPECT_TRUE(volume.source->read_slices(0, 1, slice));
    return volume;
  };
  const auto expect_changed = [&](OpenVolume& volume) {
    const auto read = volume.source->read_slices(1, 1, slice);
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message.find("changed while it was read"), std::string::npos);
  };
  const auto later = [](const std::filesystem::path& path) {
    std::filesystem::last_write_time(
        path, std::filesystem::last_write_time(path) + std::chrono::seconds(2));
  };
  write_file(folder / "v.nrrd", header + "\n" + voxels());
  auto attached = open_first(folder / "v.nrrd");
  write_file(folder / "v.nrrd", header + "\n" + other);
  later(folder / "v.nrrd");
  expect_changed(attached);

  write_file(folder / "d.nhdr", header + "data file: d.raw\n");
  write_file(folder / "d.raw", voxels());
  auto detached = open_first(folder / "d.nhdr");
  write_file(folder / "d.raw", voxels() + "more");
  expect_changed(detached);

  // The modification time may not show the change, so the beginning of the file is compared as well
  // at the end.
  write_file(folder / "e.nrrd", header + "\n" + voxels());
  auto quiet = open_first(folder / "e.nrrd");
  const auto time = std::filesystem::last_write_time(folder / "e.nrrd");
  write_file(folder / "e.nrrd", header + "\n" + other);
  std::filesystem::last_write_time(folder / "e.nrrd", time);
  const auto last = quiet.source->read_slices(2, 1, slice);
  ASSERT_FALSE(last);
  EXPECT_NE(last.error().message.find("a different beginning"), std::string::npos);
}

}  // namespace
}  // namespace isosplat::import
