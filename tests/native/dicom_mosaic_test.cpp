#include "tests/native/dicom_siemens.h"

// Siemens mosaics: the slices of a volume as tiles of one image.
namespace isosplat::import {
namespace {

using test::BallSeries;
using test::dicom_text;
using test::DicomItem;
using test::DicomWriter;
using test::expect_field;
using test::expect_note;
using test::expect_open_error;
using test::open;
using test::TempFolder;
using test::write_file;

/// A mosaic of the series' slices, from the first to the last or in reverse order.
struct MosaicFile {
  BallSeries series;
  bool against_normal = false;
  bool is_sv10 = true;
  uint32_t block = 0x10;

  MosaicFile() { series.size = {14, 13, 11}; }

  int slice(int i) const { return against_normal ? series.size.z - 1 - i : i; }

  DicomItem data() const {
    constexpr int kAcross = 4;  // 11 slices
    DicomItem data = series.slice(0);
    data[0x00080008] = dicom_text("CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC");
    data[0x00180088] = dicom_text("DS", "2");
    data[0x00280010] = test::dicom_u16(static_cast<uint16_t>(kAcross * series.size.y));
    data[0x00280011] = test::dicom_u16(static_cast<uint16_t>(kAcross * series.size.x));
    // The corner of an imaginary slice that is as large as the mosaic, and has the centre of the
    // first slice.
    const Vec3d corner = series.position(slice(0)) -
                         series.row * (series.spacing.x * (kAcross - 1) * series.size.x / 2.0) -
                         series.column * (series.spacing.y * (kAcross - 1) * series.size.y / 2.0);
    data[0x00200032] = dicom_text("DS", test::dicom_decimals({corner.x, corner.y, corner.z}));
    std::vector<std::vector<uint16_t>> slices;
    for (int i = 0; i < series.size.z; ++i) slices.push_back(series.pixels(slice(i)));
    data[0x7fe00010] = test::dicom_numbers("OW", test::tiled(slices, series.size.x, series.size.y));
    const Vec3d n = cross(series.row, series.column) * (against_normal ? -1 : 1);
    test::add_csa(data, test::csa_of_mosaic(series.size.z, {n.x, n.y, n.z}, is_sv10), block);
    return data;
  }
};

class DicomMosaic : public ::testing::Test {
 protected:
  std::filesystem::path write(const DicomItem& data, const test::DicomSyntax& syntax = {}) {
    const auto path = folder_ / fmt::format("{}.dcm", ++files_);
    write_file(path, DicomWriter(syntax).file(data));
    return path;
  }

  const TempFolder folder_;

 private:
  int files_ = 0;
};

TEST_F(DicomMosaic, EverySliceHasThePositionOfItsTile) {
  MosaicFile file;
  for (const bool against : {false, true}) {
    for (const bool is_sv10 : {true, false}) {
      file.against_normal = against;
      file.is_sv10 = is_sv10;
      file.block = is_sv10 ? 0x11 : 0x12;
      auto volume =
          open(write(file.data(), is_sv10 ? test::DicomSyntax{} : test::implicit_little()));
      expect_field(volume, file.series);
      EXPECT_EQ(volume.source->header().grid.voxels.z, file.series.size.z);
      EXPECT_TRUE(volume.notes.empty()) << ::testing::PrintToString(volume.notes);
    }
  }
  file.series.row = {0, 0.8, 0.6};
  file.series.column = {1, 0, 0};
  auto volume = open(write(file.data()));
  expect_field(volume, file.series);
}

TEST_F(DicomMosaic, TimesAreMosaicsOfOneFolder) {
  MosaicFile file;
  for (int t = 0; t < 3; ++t) {
    file.series.add = 100 * t;
    DicomItem data = file.data();
    data[0x00080018] = dicom_text("UI", fmt::format("1.2.3.4.{}", t));
    data[0x00200012] = dicom_text("IS", std::to_string(t + 1));
    data[0x00200013] = dicom_text("IS", std::to_string(t + 1));
    write(data);
  }
  expect_open_error(folder_.path(), {"found 3 at the same position", "acquisition number"});
  ImportOptions options;
  for (int t = 0; t < 3; ++t) {
    options.time_step = t;
    file.series.add = 100 * t;
    auto volume = open(folder_.path(), options);
    expect_field(volume, file.series);
  }
}

TEST_F(DicomMosaic, TheNumberOfSlicesIsAlsoInTheMrHeader) {
  const MosaicFile file;
  DicomItem data = file.data();
  data.erase(0x00291010);
  data[0x00190010] = dicom_text("LO", "SIEMENS MR HEADER");
  data[0x0019100a] = test::dicom_u16(static_cast<uint16_t>(file.series.size.z));
  auto volume = open(write(data));
  expect_field(volume, file.series);
  expect_note(volume, "does not state the normal of its slices");
}

TEST_F(DicomMosaic, AMissingDistanceIsTheThicknessWithANote) {
  const MosaicFile file;
  DicomItem data = file.data();
  data.erase(0x00180088);
  data[0x00180050] = dicom_text("DS", "2");
  auto volume = open(write(data));
  expect_field(volume, file.series);
  expect_note(volume, "2 mm is assumed, the slice thickness");
}

TEST_F(DicomMosaic, ContradictionsAndMissingHeadersAreErrors) {
  const MosaicFile file;
  DicomItem data = file.data();
  data.erase(0x00291010);
  expect_open_error(write(data), {"mosaic", "does not state the number of its slices"});
  data = file.data();
  test::add_csa(data, test::csa_of_mosaic(26, {0, 0, 1}, true));
  expect_open_error(write(data), {"mosaic of 26 slices in 6 rows and columns"});
  data = file.data();
  test::add_csa(data, test::csa_of_mosaic(11, {0, 1, 0}, true));
  expect_open_error(write(data), {"normal"});
  data = file.data();
  data.erase(0x00280030);
  expect_open_error(write(data), {"pixel spacing"});
  data = file.data();
  const std::string csa = test::csa_of_mosaic(11, {0, 0, 1}, true);
  for (size_t cut = 0; cut < csa.size(); cut += 7) {  // a damaged header is no crash
    test::add_csa(data, csa.substr(0, cut));
    static_cast<void>(open_volume(write(data), {}));
  }
}

TEST_F(DicomMosaic, ATruncatedMosaicLacksItsLastVoxels) {
  const MosaicFile file;
  const std::string bytes = DicomWriter({}).file(file.data());
  const auto path = folder_ / "cut.dcm";
  write_file(path, bytes.substr(0, bytes.size() - 3000));
  expect_open_error(path, {"--allow-truncated"});
  auto volume = open(path, test::allowing(Allowance::truncated));
  ASSERT_TRUE(volume.source);
  const auto values = test::read_all(*volume.source);
  size_t absent = 0, wrong = 0, i = 0;
  const VolumeGrid& grid = volume.source->header().grid;
  for (int z = 0; z < grid.voxels.z; ++z) {
    for (int y = 0; y < grid.voxels.y; ++y) {
      for (int x = 0; x < grid.voxels.x; ++x, ++i) {
        const double expected = file.series.value(grid.world({double(x), double(y), double(z)}));
        absent += std::isnan(values[i]);
        wrong += std::abs(values[i] - expected) > 1;
      }
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(absent, 100u);
}

}  // namespace
}  // namespace isosplat::import
