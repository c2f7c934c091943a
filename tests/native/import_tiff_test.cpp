#include <tiffio.h>

#include "tests/native/import_checks.h"

// The descriptions that ImageJ and OME programs write into TIFF stacks.
namespace isosplat {
namespace {

using test::error_of;
using test::expect_error;
using test::expect_note;
using test::open;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;

constexpr Index3 kSize{5, 4, 3};

/// Writes three pages of unsigned 16-bit voxels. `order`: the slice of each page.
void write_stack(const std::filesystem::path& path, const std::string& description,
                 double offset = 0, std::array<size_t, 3> order = {0, 1, 2}) {
  const auto values = pattern_voxels<uint16_t>(kSize, 1, offset);
  TIFF* tiff = TIFFOpen(path.c_str(), "wl");
  ASSERT_TRUE(tiff);
  for (const size_t slice : order) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 5);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 4);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, description.c_str());
    for (uint32_t y = 0; y < 4; ++y) {
      auto row = std::vector<uint16_t>(values.begin() + static_cast<long>(slice * 20 + y * 5),
                                       values.begin() + static_cast<long>(slice * 20 + y * 5 + 5));
      TIFFWriteScanline(tiff, row.data(), y);
    }
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
}

std::string image_j(const std::string& lines) {
  return "ImageJ=1.53t\nimages=3\nslices=3\nunit=mm\nspacing=3\n" + lines;
}

// ImageJ stores signed 16-bit voxels as unsigned ones with a straight line as calibration.
TEST(TiffDescriptions, ImageJsCalibrationOfValuesIsApplied) {
  const TempFolder folder;
  write_stack(folder / "v.tif", image_j("cf=0\nc0=-32768.0\nc1=1.0\nvunit=gray value\n"), 32668);
  EXPECT_EQ(read_all(*open(folder / "v.tif").source), pattern_voxels<double>(kSize, 1, -100));
  write_stack(folder / "v.tif", image_j("cf=0\nc0=5\nc1=0.5\n"));
  EXPECT_EQ(read_all(*open(folder / "v.tif").source), pattern_voxels<double>(kSize, 0.5, 5));
  write_stack(folder / "v.tif", image_j("cf=7\nc0=5\nc1=0.5\nc2=1\nc3=1\n"));
  const auto curve = open(folder / "v.tif");
  expect_note(curve, "not a straight line");
  EXPECT_EQ(read_all(*curve.source), pattern_voxels<double>(kSize));
  write_stack(folder / "v.tif", image_j("cf=0\nc0=5\n"));
  expect_error(folder / "v.tif", "c0 and c1");
}

TEST(TiffDescriptions, AxesHaveUnitsOfTheirOwn) {
  const TempFolder folder;
  write_stack(folder / "v.tif",
              "ImageJ=1.53t\nimages=3\nslices=3\nunit=mm\nyunit=mm\nzunit=um\nspacing=3000\n");
  EXPECT_DOUBLE_EQ(open(folder / "v.tif").source->header().grid.spacing.z, 3);
}

std::string ome(const std::string& attributes, const std::string& elements = "") {
  return "<?xml version=\"1.0\"?><OME><Image><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"3\" "
         "SizeC=\"1\" SizeT=\"1\" PhysicalSizeX=\"1\" PhysicalSizeY=\"2\" PhysicalSizeZ=\"3\" " +
         attributes + ">" + elements + "</Pixels></Image></OME>";
}

TEST(TiffDescriptions, OmeAxesHaveUnitsOfTheirOwn) {
  const TempFolder folder;
  write_stack(folder / "v.tif", ome("PhysicalSizeXUnit=\"mm\" PhysicalSizeZUnit=\"cm\""));
  const Vec3d spacing = open(folder / "v.tif").source->header().grid.spacing;
  EXPECT_DOUBLE_EQ(spacing.x, 1);
  EXPECT_DOUBLE_EQ(spacing.y, 2e-3);  // micrometres by default
  EXPECT_DOUBLE_EQ(spacing.z, 30);
}

TEST(TiffDescriptions, OmeAttributesMayHaveSingleQuotes) {
  const TempFolder folder;
  std::string text = ome("PhysicalSizeZUnit=\"cm\"");
  std::ranges::replace(text, '"', '\'');
  write_stack(folder / "v.tif", text);
  EXPECT_DOUBLE_EQ(open(folder / "v.tif").source->header().grid.spacing.z, 30);
}

TEST(TiffDescriptions, OmePagesInAnotherOrderAreRefused) {
  const TempFolder folder;
  const auto pages = [](std::array<int, 3> slices) {
    std::string text;
    for (int i = 0; i < 3; ++i) {
      text += fmt::format("<TiffData IFD=\"{}\" FirstZ=\"{}\" PlaneCount=\"1\"/>", i, slices[i]);
    }
    return text;
  };
  write_stack(folder / "v.tif", ome("", pages({0, 1, 2})));
  EXPECT_EQ(error_of(folder / "v.tif"), "");
  write_stack(folder / "v.tif", ome("", "<TiffData/>"));
  EXPECT_EQ(error_of(folder / "v.tif"), "");
  write_stack(folder / "v.tif", ome("", pages({2, 1, 0})), 0, {2, 1, 0});
  expect_error(folder / "v.tif", "found page 0 in the place of page 2");
}

TEST(TiffDescriptions, OmeSizesFitThePages) {
  const TempFolder folder;
  write_stack(folder / "v.tif", ome("SizeX=\"5\" SizeY=\"4\""));
  EXPECT_EQ(error_of(folder / "v.tif"), "");
  write_stack(folder / "v.tif", ome("SizeX=\"4\" SizeY=\"5\""));
  expect_error(folder / "v.tif", "expected pages of 4 × 5 voxels");
}

}  // namespace
}  // namespace isosplat
