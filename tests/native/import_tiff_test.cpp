#include <tiffio.h>

#include "tests/native/import_checks.h"

// The descriptions that ImageJ and OME programs write into TIFF stacks.
namespace isosplat::import {
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
    // tifffile describes an array in its first page alone.
    const bool is_shaped = description.starts_with('{') || description.starts_with("shape=");
    if (!is_shaped || slice == order[0]) {
      TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, description.c_str());
    }
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

TEST(TiffDescriptions, OmePagesMayHaveAnyOrder) {
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
  EXPECT_EQ(read_all(*open(folder / "v.tif").source), pattern_voxels<double>(kSize));
  write_stack(folder / "v.tif", ome("", pages({0, 1, 1})));
  expect_error(folder / "v.tif", "found two");
}

TEST(TiffDescriptions, OmeTagsMayHaveAPrefixAndUnitsAnyEncoding) {
  const TempFolder folder;
  for (const char* unit : {"&#181;m", "&#xB5;m", "&micro;m", "\u00b5m", "\u03bcm", "\xb5m",
                           "\u00c2\u00b5m", "um", "?m", "\ufffdm"}) {
    SCOPED_TRACE(unit);
    write_stack(folder / "v.tif", ome(fmt::format("PhysicalSizeZUnit=\"{}\"", unit)));
    EXPECT_DOUBLE_EQ(open(folder / "v.tif").source->header().grid.spacing.z, 3e-3);
  }
  std::string text = ome("PhysicalSizeZUnit=\"cm\"");
  for (const char* name : {"OME", "Image", "Pixels"}) {
    for (const std::string before : {"<", "</"}) {
      const size_t at = text.find(before + name);
      if (at != text.npos) text.insert(at + before.size(), "ome:");
    }
  }
  write_stack(folder / "v.tif", text);
  EXPECT_DOUBLE_EQ(open(folder / "v.tif").source->header().grid.spacing.z, 30);
}

// Descriptions that state the size of pixels, but no distance between slices.
TEST(TiffDescriptions, PixelSizesAreKeptWithoutADistanceBetweenSlices) {
  const TempFolder folder;
  std::string text = ome("");
  text.erase(text.find("PhysicalSizeZ=\"3\""), 17);
  write_stack(folder / "v.tif", text);
  const auto volume = open(folder / "v.tif");
  const Vec3d spacing = volume.source->header().grid.spacing;
  EXPECT_DOUBLE_EQ(spacing.x, 1e-3);
  EXPECT_DOUBLE_EQ(spacing.y, 2e-3);
  EXPECT_DOUBLE_EQ(spacing.z, 1e-3);
  expect_note(volume, "no distance between slices: 1 um is assumed");
  write_stack(folder / "v.tif", "ImageJ=1.53t\nimages=3\nslices=3\nunit=um\n");
  const auto imagej = open(folder / "v.tif");
  EXPECT_DOUBLE_EQ(imagej.source->header().grid.spacing.z, 1e-3);
  expect_note(imagej, "ImageJ leaves out if it is 1");
}

TEST(TiffDescriptions, SeveralVolumesAreAChoice) {
  const TempFolder folder;
  int asked = 0;
  const auto expect_choices = [&](const std::string& description, const std::string& error,
                                  std::vector<std::string> labels) {
    SCOPED_TRACE(description);
    write_stack(folder / "v.tif", description);
    if (!error.empty()) expect_error(folder / "v.tif", error);
    const auto choices = volumes_in_file(folder / "v.tif");
    std::vector<std::string> found;
    if (choices) {
      for (const VolumeChoice& choice : *choices) found.push_back(choice.label);
    } else {
      EXPECT_NE(choices.error().message.find(error), std::string::npos) << choices.error().message;
    }
    EXPECT_EQ(found, labels);
    // If a choice is required, each offered choice selects a volume.
    std::vector<VolumeChoice> offered;
    ImportOptions options;
    options.choices = &offered;
    if (open_volume(folder / "v.tif", options) || offered.empty()) return;
    const bool is_allowance = offered.front().allowance.has_value();
    EXPECT_EQ(offered.size(), is_allowance ? 1 : labels.size());
    for (const VolumeChoice& choice : offered) {
      ImportOptions chosen;
      chosen.series = choice.series;
      chosen.channel = choice.channel;
      chosen.time_step = choice.time_step;
      if (is_allowance) chosen.allowed.add(*choice.allowance);
      // Some of the files lack pages. Even these must require no further choice.
      const auto volume = open_volume(folder / "v.tif", chosen);
      const std::string message = volume ? "" : volume.error().message;
      EXPECT_EQ(message.find("choose"), std::string::npos) << choice.label << ": " << message;
    }
    ++asked;
  };
  expect_choices("{\"shape\": [3, 4, 5]}", "", {});
  expect_choices("{\"shape\": [1, 3, 4, 5]}", "", {});
  expect_choices("{\"shape\": [3, 5, 4]}", "expected an array like its description says", {});
  expect_choices("{\"shape\": [2, 3, 4, 5]}", "--time-step 0 to --time-step 1, or",
                 {"volume 0", "volume 1"});
  expect_choices("{\"shape\": [3, 2, 4, 5], \"axes\": \"ZCYX\"}",
                 "found 2 channels: choose one with --channel 0 to --channel 1",
                 {"channel 0", "channel 1"});
  expect_choices("{\"shape\": [2, 2, 3, 4, 5]}", "save one volume as a separate file", {});
  expect_choices("ImageJ=1.53t\nimages=3\nframes=3\n", "--allow-frames", {});
  expect_choices("ImageJ=1.53t\nimages=3\nchannels=3\n", "--allow-frames", {});
  std::string text = ome("");
  const std::string image =
      text.substr(text.find("<Image"), text.find("</OME>") - text.find("<Image"));
  text.insert(text.find("<Image"), image);
  expect_choices(text, "expected one volume, found 2 images: choose one of --series 1 (3 slices)",
                 {"image 1", "image 2"});
  text = ome("");
  text.replace(text.find("SizeC=\"1\""), 9, "SizeC=\"2\"");
  text.insert(text.find("</Pixels>"), "<Channel Name=\"DAPI\"/><Channel Name=\"GFP\"/>");
  expect_choices(text, "found 2 channels (DAPI, GFP)", {"DAPI", "GFP"});
  EXPECT_EQ(asked, 6);
}

TEST(TiffDescriptions, StepsHaveTheTimesOfTheDescription) {
  const TempFolder folder;
  const auto expect_times = [&](const std::string& description, double second,
                                const std::string& unit) {
    SCOPED_TRACE(description);
    write_stack(folder / "v.tif", description);
    const auto offered = test::offered_choices(folder / "v.tif");
    ASSERT_EQ(offered.size(), 2u);
    EXPECT_EQ(offered[0].time, 0.0);
    EXPECT_EQ(offered[1].time, second);
    EXPECT_EQ(offered[1].time_unit, unit);
  };
  const std::string imagej = "ImageJ=1.53t\nimages=6\nslices=3\nframes=2\nfinterval=0.5\n";
  expect_times(imagej, 0.5, "s");
  expect_times(imagej + "tunit=sec\n", 0.5, "s");
  expect_times(imagej + "tunit=min\n", 0.5, "min");
  std::string text = ome("");
  text.replace(text.find("SizeT=\"1\""), 9, "SizeT=\"2\" TimeIncrement=\"30\"");
  expect_times(text, 30, "s");
  text.insert(text.find("TimeIncrement"), "TimeIncrementUnit=\"ms\" ");
  expect_times(text, 30, "ms");
}

TEST(TiffDescriptions, TimesAndChannelsMayBeSlices) {
  const TempFolder folder;
  ImportOptions options;
  options.allowed.add(Allowance::frames);
  for (const char* text :
       {"ImageJ=1.53t\nimages=3\nframes=3\n", "ImageJ=1.53t\nimages=3\nchannels=3\n",
        "{\"shape\": [3, 4, 5], \"axes\": \"TYX\"}"}) {
    write_stack(folder / "v.tif", text);
    const auto volume = open(folder / "v.tif", options);
    EXPECT_EQ(read_all(*volume.source), pattern_voxels<double>(kSize));
    expect_note(volume, "are read as slices");
  }
}

TEST(TiffDescriptions, OmeSizesFitThePages) {
  const TempFolder folder;
  write_stack(folder / "v.tif", ome("SizeX=\"5\" SizeY=\"4\""));
  EXPECT_EQ(error_of(folder / "v.tif"), "");
  write_stack(folder / "v.tif", ome("SizeX=\"4\" SizeY=\"5\""));
  expect_error(folder / "v.tif", "expected pages of 4 × 5 voxels");
}

}  // namespace
}  // namespace isosplat::import
