#include <tiffio.h>

#include <cmath>

#include "tests/native/volume_files.h"

namespace isosplat::import {
namespace {

using test::byte_swapped;
using test::bytes_of;
using test::deflated;
using test::nrrd_header;
using test::pattern;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

OpenVolume open(const std::filesystem::path& path, const ImportOptions& options = {}) {
  auto volume = open_volume(path, options);
  EXPECT_TRUE(volume) << volume.error().message;
  return volume ? std::move(*volume) : OpenVolume{};
}

/// Expects the pattern's voxels, read all at once and slice by slice, also backwards.
void expect_pattern(OpenVolume& volume, VoxelType type, double scale = 1, double offset = 0) {
  ASSERT_TRUE(volume.source);
  const VolumeHeader& header = volume.source->header();
  EXPECT_EQ(header.grid.voxels, kSize);
  ASSERT_STREQ(voxel_type_name(header.type), voxel_type_name(type));
  const auto all = read_all(*volume.source);
  EXPECT_EQ(all, pattern_voxels<double>(kSize, scale, offset));
  const size_t slice = static_cast<size_t>(kSize.x * kSize.y) * voxel_bytes(type);
  std::vector<std::byte> whole(3 * slice), one(slice);
  ASSERT_TRUE(volume.source->read_slices(0, 3, whole));
  for (int32_t z = 2; z >= 0; --z) {
    ASSERT_TRUE(volume.source->read_slices(z, 1, one));
    EXPECT_TRUE(std::equal(one.begin(), one.end(), whole.begin() + z * static_cast<int>(slice)));
  }
  EXPECT_FALSE(volume.source->read_slices(2, 2, whole));
  const size_t row = slice / static_cast<size_t>(kSize.y);
  std::vector<std::byte> rows(2 * 2 * row);
  for (int32_t y = 0; y + 2 <= kSize.y; ++y) {
    ASSERT_TRUE(volume.source->read_rows({1, 2, y, 2}, rows));
    for (size_t z = 0; z < 2; ++z) {
      const size_t from = (1 + z) * slice + static_cast<size_t>(y) * row;
      EXPECT_TRUE(std::equal(rows.begin() + static_cast<ptrdiff_t>(z * 2 * row),
                             rows.begin() + static_cast<ptrdiff_t>((z + 1) * 2 * row),
                             whole.begin() + static_cast<ptrdiff_t>(from)));
    }
  }
}

TEST(ImportNrrd, ReadsEveryTypeInBothByteOrders) {
  const TempFolder folder;
  const auto check = [&]<class T>(T, const char* name, VoxelType type) {
    for (const bool big : {false, true}) {
      for (const bool gzip : {false, true}) {
        auto voxels = pattern_voxels<T>(kSize, sizeof(T) == 1 ? 0.25 : 1);
        if (big != (std::endian::native == std::endian::big)) voxels = byte_swapped(voxels);
        const std::string data = bytes_of(voxels);
        write_file(folder / "v.nrrd",
                   nrrd_header(kSize, name,
                               fmt::format("endian: {}\nencoding: {}\n\n", big ? "big" : "little",
                                           gzip ? "gzip" : "raw")) +
                       (gzip ? deflated(data) : data));
        auto volume = open(folder / "v.nrrd");
        ASSERT_TRUE(volume.source);
        EXPECT_EQ(volume.source->header().type, type) << name;
        EXPECT_EQ(volume.source->resident_bytes(), 0u);
        std::vector<double> expected;
        for (const T v : pattern_voxels<T>(kSize, sizeof(T) == 1 ? 0.25 : 1)) {
          expected.push_back(static_cast<double>(v));
        }
        EXPECT_EQ(read_all(*volume.source), expected) << name << big << gzip;
      }
    }
  };
  check(uint8_t{}, "uchar", VoxelType::u8);
  check(int8_t{}, "signed char", VoxelType::i8);
  check(uint16_t{}, "unsigned short", VoxelType::u16);
  check(int16_t{}, "int16", VoxelType::i16);
  check(uint32_t{}, "uint32_t", VoxelType::u32);
  check(int32_t{}, "int", VoxelType::i32);
  check(float{}, "float", VoxelType::f32);
  check(double{}, "double", VoxelType::f64);
  check(int64_t{}, "int64", VoxelType::i64);
  check(uint64_t{}, "uint64", VoxelType::u64);
}

TEST(ImportNrrd, ReadsDetachedDataWithSkips) {
  const TempFolder folder;
  const std::string data = bytes_of(pattern_voxels<int16_t>(kSize));
  write_file(folder / "data.bin", "line one\nline two\n??" + data);
  write_file(folder / "v.nhdr",
             nrrd_header(kSize, "short",
                         "spacings: 0.5 0.75 2\nendian: little\nencoding: raw\nline skip: 2\n"
                         "byte skip: 2\ndata file: data.bin"));
  auto volume = open(folder / "v.nhdr");
  expect_pattern(volume, VoxelType::i16);
  EXPECT_EQ(volume.source->header().grid.spacing, (Vec3d{0.5, 0.75, 2}));
  EXPECT_EQ(volume.source->header().name, "v");
  EXPECT_EQ(volume.source->header().format, "NRRD");

  write_file(folder / "w.nhdr", nrrd_header(kSize, "short",
                                            "endian: little\nencoding: raw\nbyte skip: -1\n"
                                            "data file: ./data.bin\n"));
  auto from_end = open(folder / "w.nhdr");
  expect_pattern(from_end, VoxelType::i16);
}

TEST(ImportNrrd, ReadsACompressedFileInsteadOfAMissingOne) {
  const TempFolder folder;
  write_file(folder / "v.raw.gz", deflated(bytes_of(pattern_voxels<uint8_t>(kSize))));
  write_file(folder / "v.nhdr",
             nrrd_header(kSize, "uint8",
                         "space: lps\nspace directions: (2,0,0) (0,3,0) (0,0,4)\n"
                         "space origin: (1,2,3)\nencoding: raw\ndata file: v.raw\n"));
  auto volume = open(folder / "v.nhdr");
  expect_pattern(volume, VoxelType::u8);
  ASSERT_EQ(volume.notes.size(), 1u);
  EXPECT_NE(volume.notes[0].find("v.raw.gz"), std::string::npos);
  EXPECT_EQ(volume.source->header().grid.spacing, (Vec3d{2, 3, 4}));
  EXPECT_EQ(volume.source->header().grid.origin, (Vec3d{1, 2, 3}));
}

TEST(ImportNrrd, ReadsText) {
  const TempFolder folder;
  std::string text;
  for (const int v : pattern_voxels<int>(kSize)) text += fmt::format("{} ", v);
  write_file(folder / "v.nrrd", nrrd_header(kSize, "short", "encoding: ascii\n\n") + text);
  auto volume = open(folder / "v.nrrd");
  expect_pattern(volume, VoxelType::i16);
  EXPECT_EQ(volume.source->resident_bytes(), 0u);
}

TEST(ImportNrrd, ReadsSeveralGzipMembers) {
  const TempFolder folder;
  const std::string data = bytes_of(pattern_voxels<uint8_t>(kSize));
  write_file(folder / "v.nrrd", nrrd_header(kSize, "uint8", "encoding: gzip\n\n") +
                                    deflated(data.substr(0, 17)) + deflated(data.substr(17)) +
                                    "trailing");
  auto volume = open(folder / "v.nrrd");
  expect_pattern(volume, VoxelType::u8);
}

TEST(ImportNrrd, ChoosesATimeStep) {
  const TempFolder folder;
  std::string data;
  for (int t = 0; t < 3; ++t) {
    data += bytes_of(pattern_voxels<int16_t>(kSize, 1, 1000 * t));
  }
  write_file(folder / "v.nrrd",
             "NRRD0004\ntype: short\ndimension: 4\nspace: lps\nsizes: 5 4 3 3\n"
             "space directions: (1,0,0) (0,2,0) (0,0,3) none\nkinds: domain domain domain list\n"
             "endian: little\nencoding: raw\n\n" +
                 data);
  ImportOptions options;
  options.time_step = 2;
  auto volume = open(folder / "v.nrrd", options);
  expect_pattern(volume, VoxelType::i16, 1, 2000);
  EXPECT_EQ(volume.source->header().grid.spacing, (Vec3d{1, 2, 3}));

  const auto none = open_volume(folder / "v.nrrd", {});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("3 time steps: choose one with --time-step 0 to"),
            std::string::npos)
      << none.error().message;
  options.time_step = 3;
  EXPECT_FALSE(open_volume(folder / "v.nrrd", options));
}

TEST(ImportMetaImage, ReadsLocalDetachedCompressedAndSkipped) {
  const TempFolder folder;
  const auto header = [&](const std::string& more) {
    return "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 5 4 3\n"
           "ElementSpacing = 0.5 0.5 2\nOffset = 1 2 3\nElementType = MET_SHORT\n" +
           more;
  };
  const std::string data = bytes_of(pattern_voxels<int16_t>(kSize));
  const std::string swapped = bytes_of(byte_swapped(pattern_voxels<int16_t>(kSize)));
  write_file(folder / "a.mha", header("ElementDataFile = LOCAL\n") + data);
  write_file(folder / "b.mhd", header("BinaryDataByteOrderMSB = True\nElementDataFile = b.raw\n"));
  write_file(folder / "b.raw", swapped);
  write_file(folder / "c.mha",
             header("CompressedData = True\nElementDataFile = LOCAL\n") + deflated(data, 15));
  write_file(folder / "d.mhd", header("HeaderSize = -1\nElementDataFile = d.raw"));
  write_file(folder / "d.raw", "anything at all" + data);
  write_file(folder / "e.mhd", header("HeaderSize = 7\nElementDataFile = e.raw\n"));
  write_file(folder / "e.raw", "1234567" + data);
  for (const char* name : {"a.mha", "b.mhd", "c.mha", "d.mhd", "e.mhd"}) {
    SCOPED_TRACE(name);
    auto volume = open(folder / name);
    expect_pattern(volume, VoxelType::i16);
    EXPECT_EQ(volume.source->header().grid.spacing, (Vec3d{0.5, 0.5, 2}));
    EXPECT_EQ(volume.source->header().grid.origin, (Vec3d{1, 2, 3}));
    EXPECT_EQ(volume.source->resident_bytes(), 0u);
  }
}

TEST(ImportNifti, ReadsPlainAndCompressedAndScaled) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {5, 4, 3};
  file.voxels = bytes_of(pattern_voxels<int16_t>(kSize));
  write_file(folder / "a.nii", file.bytes());
  write_file(folder / "b.nii.gz", deflated(file.bytes()));
  for (const char* name : {"a.nii", "b.nii.gz"}) {
    auto volume = open(folder / name);
    expect_pattern(volume, VoxelType::i16);
    EXPECT_EQ(volume.source->header().name, std::string(name).substr(0, 1));
  }
  file.slope = 0.5f;
  file.intercept = -100;
  write_file(folder / "c.nii", file.bytes());
  auto scaled = open(folder / "c.nii");
  expect_pattern(scaled, VoxelType::i16, 0.5, -100);
  EXPECT_EQ(scaled.source->header().slope, 0.5);
  EXPECT_EQ(scaled.source->header().intercept, -100);

  file.slope = 0;
  file.sizes = {5, 4, 3, 2};
  file.voxels += bytes_of(pattern_voxels<int16_t>(kSize, -1));
  write_file(folder / "d.nii", file.bytes());
  ImportOptions options;
  options.time_step = 1;
  auto second = open(folder / "d.nii", options);
  expect_pattern(second, VoxelType::i16, -1);
}

TEST(ImportNifti, ConvertsRasToLps) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {5, 4, 3};
  file.rows = {{{2, 0, 0, 10}, {0, 3, 0, 20}, {0, 0, 4, 30}}};
  file.voxels = bytes_of(pattern_voxels<int16_t>(kSize));
  write_file(folder / "a.nii", file.bytes());
  auto volume = open(folder / "a.nii");
  const VolumeGrid& grid = volume.source->header().grid;
  EXPECT_EQ(grid.spacing, (Vec3d{2, 3, 4}));
  EXPECT_EQ(grid.world({1, 1, 1}), (Vec3d{-12, -23, 34}));
}

TEST(ImportNifti, HasTheFrameOfReferenceOfItsTransform) {
  struct Case {
    int16_t code;
    const char* frame;
  };
  for (const Case& c : {Case{1, "scanner"}, Case{2, ""}, Case{3, "talairach"}, Case{4, "mni152"},
                        Case{5, ""}, Case{0, ""}}) {
    const TempFolder folder;
    test::NiftiFile file;
    file.sizes = {5, 4, 3};
    file.affine_code = c.code;
    file.voxels = bytes_of(pattern_voxels<int16_t>(kSize));
    write_file(folder / "a.nii", file.bytes());
    EXPECT_EQ(open(folder / "a.nii").source->header().frame_of_reference, c.frame) << c.code;
  }
}

// With and without a rotation beside it that contradicts it.
TEST(ImportNifti, KeepsTheShearOfItsAffineTransform) {
  for (const bool rotation : {false, true}) {
    const TempFolder folder;
    test::NiftiFile file;
    file.sizes = {5, 4, 3};
    file.rows = {{{2, 0.4f, 0, 10}, {0, 3, 0, 20}, {0, 0, 4, 30}}};
    file.has_rotation = rotation;
    file.voxels = bytes_of(pattern_voxels<int16_t>(kSize));
    write_file(folder / "a.nii", file.bytes());
    auto volume = open(folder / "a.nii");
    expect_pattern(volume, VoxelType::i16);
    EXPECT_EQ(volume.notes.size(), rotation ? 1u : 0u) << "a note about the transform that is used";
    const VolumeGrid& grid = volume.source->header().grid;
    EXPECT_NEAR(length(grid.world({1, 2, 2}) - Vec3d{-12.8, -26, 38}), 0, 1e-6);
    EXPECT_NEAR(shear_degrees(grid.direction), std::atan(0.4 / 3) * 180 / 3.14159265358979, 1e-5);
  }
}

// A CT with gantry tilt: the y axis also points up.
TEST(ImportNifti, KeepsGantryTilt) {
  ISOSPLAT_NEEDS_VOLUMES(volumes);
  auto volume = open(volumes / "ct_shear.nii.gz");
  ASSERT_EQ(volume.notes.size(), 1u);
  EXPECT_NE(volume.notes[0].find("the sform is used"), std::string::npos);
  const VolumeGrid& grid = volume.source->header().grid;
  EXPECT_NEAR(shear_degrees(grid.direction), 18.5, 0.05);
  // The header's rows times (0, 100, 10, 1), converted from RAS to LPS.
  const Vec3d place = grid.world({0, 100, 10});
  EXPECT_NEAR(place.x, 94.379356, 1e-4);
  EXPECT_NEAR(place.y, 117.106018 - 45.749205, 1e-4);
  EXPECT_NEAR(place.z, -102.203552 + 15.307474 + 23.708093, 1e-4);
}

TEST(ImportVtk, ReadsBinaryAndText) {
  const TempFolder folder;
  const std::string header =
      "# vtk DataFile Version 3.0\na title\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n"
      "SPACING 0.5 1 2\nORIGIN 1 2 3\nPOINT_DATA 60\nSCALARS density short 1\n"
      "LOOKUP_TABLE default\n";
  write_file(folder / "a.vtk", fmt::format(fmt::runtime(header), "BINARY") +
                                   bytes_of(byte_swapped(pattern_voxels<int16_t>(kSize))));
  std::string text;
  for (const int v : pattern_voxels<int>(kSize)) text += fmt::format("{}\n", v);
  write_file(folder / "b.vtk", fmt::format(fmt::runtime(header), "ASCII") + text);
  for (const char* name : {"a.vtk", "b.vtk"}) {
    SCOPED_TRACE(name);
    auto volume = open(folder / name);
    expect_pattern(volume, VoxelType::i16);
    EXPECT_EQ(volume.source->header().grid.spacing, (Vec3d{0.5, 1, 2}));
    EXPECT_EQ(volume.source->header().grid.origin, (Vec3d{1, 2, 3}));
    EXPECT_EQ(volume.source->resident_bytes(), 0u);
  }
}

struct TiffPage {
  std::vector<uint16_t> voxels;
  uint16_t photometric = PHOTOMETRIC_MINISBLACK;
  bool tiled = false;
  uint16_t compression = COMPRESSION_NONE;
  std::string description;
  float resolution = 0;
};

/// Pages of 5 × 4 voxels.
void write_tiff(const std::filesystem::path& path, const std::vector<TiffPage>& pages,
                const char* mode) {
  TIFF* tiff = TIFFOpen(path.c_str(), mode);
  ASSERT_TRUE(tiff);
  for (const TiffPage& page : pages) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 5);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 4);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, page.photometric);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, page.compression);
    if (!page.description.empty()) {
      TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, page.description.c_str());
    }
    if (page.resolution > 0) {
      TIFFSetField(tiff, TIFFTAG_XRESOLUTION, static_cast<double>(page.resolution));
      TIFFSetField(tiff, TIFFTAG_YRESOLUTION, static_cast<double>(page.resolution));
    }
    if (page.tiled) {
      TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
      TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
      std::vector<uint16_t> tile(256, 77);
      for (size_t y = 0; y < 4; ++y) {
        for (size_t x = 0; x < 5; ++x) tile[16 * y + x] = page.voxels[5 * y + x];
      }
      TIFFWriteTile(tiff, tile.data(), 0, 0, 0, 0);
    } else {
      TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 3);  // the last strip is shorter
      auto voxels = page.voxels;
      for (uint32_t y = 0; y < 4; ++y) TIFFWriteScanline(tiff, &voxels[5 * y], y);
    }
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
}

std::vector<TiffPage> pattern_pages(const TiffPage& like) {
  const auto voxels = pattern_voxels<uint16_t>(kSize);
  std::vector<TiffPage> pages(3, like);
  for (int z = 0; z < 3; ++z) {
    pages[static_cast<size_t>(z)].voxels.assign(voxels.begin() + 20 * z,
                                                voxels.begin() + 20 * z + 20);
  }
  return pages;
}

TEST(ImportTiff, ReadsPagesStripsTilesAndBothByteOrders) {
  const TempFolder folder;
  write_tiff(folder / "strips.tif", pattern_pages({}), "wl");
  write_tiff(folder / "big_endian.tif", pattern_pages({}), "wb");
  write_tiff(folder / "big_tiff.tif", pattern_pages({}), "w8");
  TiffPage page;
  page.tiled = true;
  write_tiff(folder / "tiles.tif", pattern_pages(page), "wl");
  page.tiled = false;
  page.compression = COMPRESSION_LZW;
  write_tiff(folder / "lzw.tif", pattern_pages(page), "wl");
  for (const char* name :
       {"strips.tif", "big_endian.tif", "big_tiff.tif", "tiles.tif", "lzw.tif"}) {
    SCOPED_TRACE(name);
    auto volume = open(folder / name);
    expect_pattern(volume, VoxelType::u16);
    EXPECT_EQ(volume.notes.size(), 1u) << "the unknown spacing";
    EXPECT_EQ(volume.source->resident_bytes(), 0u);
  }
  page = {};
  page.photometric = PHOTOMETRIC_MINISWHITE;
  write_tiff(folder / "white.tif", pattern_pages(page), "wl");
  auto white = open(folder / "white.tif");
  expect_pattern(white, VoxelType::u16, -1, 65535);
}

TEST(ImportTiff, ReadsAFolderInTheOrderOfItsNumbers) {
  const TempFolder folder;
  const auto pages = pattern_pages({});
  for (size_t z = 0; z < 3; ++z) {
    write_tiff(folder / fmt::format("slice_{}.tif", z * 6 + 3), {pages[z]}, "wl");  // 3, 9, 15
  }
  write_file(folder / "notes.txt", "not a slice");
  ImportOptions options;
  options.spacing = Vec3d{1, 1, 2};
  auto volume = open(folder.path(), options);
  expect_pattern(volume, VoxelType::u16);
  EXPECT_EQ(volume.source->header().grid.spacing, (Vec3d{1, 1, 2}));
  EXPECT_TRUE(volume.notes.empty());
}

TEST(ImportTiff, ReadsTheSpacingThatImageJWrites) {
  const TempFolder folder;
  TiffPage page;
  page.description = "ImageJ=1.53t\nimages=3\nslices=3\nunit=micron\nspacing=2.5\nloop=false\n";
  page.resolution = 4;
  write_tiff(folder / "stack.tif", pattern_pages(page), "wl");
  auto volume = open(folder / "stack.tif");
  EXPECT_NEAR(length(volume.source->header().grid.spacing - Vec3d{2.5e-4, 2.5e-4, 2.5e-3}), 0, 1e-9)
      << "millimetres";
  EXPECT_TRUE(volume.notes.empty());
}

TEST(ImportRaw, UsesOptionsOrTheName) {
  const TempFolder folder;
  write_file(folder / "v.raw", "hd" + bytes_of(byte_swapped(pattern_voxels<int16_t>(kSize))));
  ImportOptions options;
  options.dims = {5, 4, 3};
  options.type = VoxelType::i16;
  options.big_endian = true;
  options.skip_bytes = 2;
  options.spacing = Vec3d{1, 2, 3};
  auto volume = open(folder / "v.raw", options);
  expect_pattern(volume, VoxelType::i16);
  EXPECT_EQ(volume.source->header().grid.spacing, (Vec3d{1, 2, 3}));

  write_file(folder / "foot_5x4x3_uint8.raw", bytes_of(pattern_voxels<uint8_t>(kSize)));
  auto named = open(folder / "foot_5x4x3_uint8.raw");
  expect_pattern(named, VoxelType::u8);
  EXPECT_EQ(named.notes.size(), 2u);  // dims and type; the spacing

  write_file(folder / "zipped.raw.gz", deflated(bytes_of(pattern_voxels<uint8_t>(kSize))));
  options = {};
  options.dims = {5, 4, 3};
  options.type = VoxelType::u8;
  auto zipped = open(folder / "zipped.raw.gz", options);
  expect_pattern(zipped, VoxelType::u8);
}

TEST(Import, ReadsTheRealVolumes) {
  ISOSPLAT_NEEDS_VOLUMES(volumes);
  struct Expected {
    const char* name;
    Index3 voxels;
    VoxelType type;
    Vec3d spacing;
    double low, high;
  };
  const Expected all[] = {
      {"fuel.nhdr", {64, 64, 64}, VoxelType::u8, {1, 1, 1}, 0, 255},
      {"engine.nhdr", {256, 256, 128}, VoxelType::u8, {1, 1, 1}, 0, 255},
      {"aneurysm.nhdr", {256, 256, 256}, VoxelType::u8, {1, 1, 1}, 0, 255},
      {"lobster.nhdr", {301, 324, 56}, VoxelType::u8, {1, 1, 1.4}, 0, 255},
      {"BostonTeapot.nhdr", {256, 256, 178}, VoxelType::u8, {1, 1, 1}, 0, 255},
      {"statueLeg.nhdr", {341, 341, 93}, VoxelType::u8, {1, 1, 4}, 0, 250},
      {"hydrogenAtom.nhdr", {128, 128, 128}, VoxelType::u8, {1, 1, 1}, 0, 250},
      {"neghip.nhdr", {64, 64, 64}, VoxelType::u8, {1, 1, 1}, 0, 255},
      {"nucleon.nhdr", {41, 41, 41}, VoxelType::u8, {1, 1, 1}, 0, 249},
      {"marschnerlobb.nhdr", {41, 41, 41}, VoxelType::u8, {1, 1, 1}, 0, 255},
      {"shockwave.nhdr", {64, 64, 512}, VoxelType::u8, {1, 1, 1}, 0, 255},
      {"fetal_atlas_f32.nrrd",
       {117, 159, 126},
       VoxelType::f32,
       {0.859375, 0.859375, 0.859375},
       0,
       710.678},
      {"eun_brain.nii.gz", {256, 190, 151}, VoxelType::u8, {1, 1, 1}, 0, 180},
      {"mni152.nii.gz", {193, 229, 193}, VoxelType::i16, {1, 1, 1}, 0, 1570},
      {"iron_protein.vtk", {68, 68, 68}, VoxelType::u8, {1, 1, 1}, 0, 255},
      {"cthead_tif", {256, 256, 99}, VoxelType::u16, {1, 1, 2}, 0, 3272},
      {"mr_t1_dicom", {274, 384, 384}, VoxelType::i16, {0.7, 0.667, 0.667}, 0, 278},
  };
  for (const Expected& expected : all) {
    SCOPED_TRACE(expected.name);
    ImportOptions options;
    if (std::string(expected.name) == "cthead_tif") options.spacing = Vec3d{1, 1, 2};
    auto volume = open(volumes / expected.name, options);
    if (!volume.source) continue;
    const VolumeHeader& header = volume.source->header();
    EXPECT_EQ(header.grid.voxels, expected.voxels);
    EXPECT_STREQ(voxel_type_name(header.type), voxel_type_name(expected.type));
    EXPECT_NEAR(length(header.grid.spacing - expected.spacing), 0, 1e-3);
    const auto values = read_all(*volume.source);
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    EXPECT_EQ(*low, expected.low);
    EXPECT_NEAR(*high, expected.high, 1e-3);
  }
}

}  // namespace
}  // namespace isosplat::import
