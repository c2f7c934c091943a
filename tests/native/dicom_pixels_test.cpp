#include <numeric>

#include "shared/import/dicom/elements.h"
#include "tests/native/dicom_encode.h"
#include "tests/native/dicom_files.h"

// Encodings of pixels and elements: transfer syntaxes, codecs, and damaged data.
namespace isosplat::import {
namespace {

using test::BallSeries;
using test::dicom_text;
using test::DicomItem;
using test::DicomWriter;
using test::encode;
using test::expect_field;
using test::TempFolder;
using test::write_file;

std::vector<int> frames_of(const BallSeries& series) {
  std::vector<int> order(static_cast<size_t>(series.size.z));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// PackBits, as in PS3.5 annex G, with literal runs only. The segments are the high bytes and the
/// low bytes.
std::string run_lengths(const std::vector<uint16_t>& pixels) {
  std::string segments[2];
  for (int low = 0; low < 2; ++low) {
    for (size_t i = 0; i < pixels.size(); i += 128) {
      const size_t count = std::min<size_t>(128, pixels.size() - i);
      segments[low] += static_cast<char>(count - 1);
      for (size_t k = i; k < i + count; ++k) {
        segments[low] += static_cast<char>(low ? pixels[k] & 255 : pixels[k] >> 8);
      }
    }
    if (segments[low].size() % 2) segments[low] += static_cast<char>(0x80);
  }
  std::vector<uint32_t> head(16);
  head[0] = 2;
  head[1] = 64;
  head[2] = 64 + static_cast<uint32_t>(segments[0].size());
  return test::bytes_of(head) + segments[0] + segments[1];
}

const test::DicomSyntax kRle{"1.2.840.10008.1.2.5", true, false, false, false, true};

TEST(DicomPixels, EverySyntaxOfElementsGivesTheSameSlices) {
  for (test::DicomSyntax syntax : {test::DicomSyntax{}, test::implicit_little(),
                                   test::explicit_big(), test::deflated_little()}) {
    for (const bool has_prefix : {true, false}) {
      if (syntax.deflated && !has_prefix) continue;
      SCOPED_TRACE(syntax.uid);
      const TempFolder folder;
      BallSeries series;
      series.syntax = syntax;
      series.syntax.has_prefix = has_prefix;
      series.write(folder);
      auto volume = open_volume(folder.path(), {});
      ASSERT_TRUE(volume) << volume.error().message;
      expect_field(*volume, series);
    }
  }
}

TEST(DicomPixels, BigEndianBytesInWordsAreSwapped) {
  const TempFolder folder;
  BallSeries series;
  series.syntax = test::explicit_big();
  series.slope = 16;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    for (const uint32_t tag : {0x00280100u, 0x00280101u}) data[tag] = test::dicom_u16(8);
    data[0x00280102] = test::dicom_u16(7);
    const auto pixels = series.pixels(z);
    const std::vector<uint8_t> bytes(pixels.begin(), pixels.end());
    data[0x7fe00010] = {"OW", test::bytes_of(bytes), 2, {}};
    series.write_slice(folder, z, data);
  }
  auto volume = open_volume(folder.path(), {});
  ASSERT_TRUE(volume) << volume.error().message;
  expect_field(*volume, series, 8.5);
}

/// A series of slices with floating-point pixels.
template <class Pixel>
void expect_floats(uint32_t tag, const std::string& vr, VoxelType type) {
  const TempFolder folder;
  const BallSeries series;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    data.erase(0x7fe00010);
    const auto numbers = series.pixels(z);
    const std::vector<Pixel> pixels(numbers.begin(), numbers.end());
    data[0x00280100] = test::dicom_u16(8 * sizeof(Pixel));
    data[tag] = test::dicom_numbers(vr, pixels);
    series.write_slice(folder, z, data);
  }
  auto volume = open_volume(folder.path(), {});
  ASSERT_TRUE(volume) << volume.error().message;
  EXPECT_EQ(volume->source->header().type, type);
  expect_field(*volume, series);
}

TEST(DicomPixels, FloatsAreReadUnchanged) {
  expect_floats<float>(0x7fe00008, "OF", VoxelType::f32);
  expect_floats<double>(0x7fe00009, "OD", VoxelType::f64);
}

TEST(DicomPixels, RunLengthsInASliceAndInFrames) {
  const TempFolder folder;
  BallSeries series;
  series.syntax = kRle;
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    data[0x7fe00010] = test::dicom_fragments({run_lengths(series.pixels(z))});
    series.write_slice(folder, z, data);
  }
  auto volume = open_volume(folder.path(), {});
  ASSERT_TRUE(volume) << volume.error().message;
  expect_field(*volume, series);

  DicomItem frames = series.enhanced(frames_of(series));
  std::vector<std::string> fragments;
  for (int z = 0; z < series.size.z; ++z) fragments.push_back(run_lengths(series.pixels(z)));
  frames[0x7fe00010] = test::dicom_fragments(fragments);
  write_file(folder / "frames", DicomWriter(kRle).file(frames));
  volume = open_volume(folder / "frames", {});
  ASSERT_TRUE(volume) << volume.error().message;
  expect_field(*volume, series);

  // Truncated within the last fragments: an error, or only the complete frames.
  const std::string whole = test::read_file(folder / "frames");
  write_file(folder / "frames", whole.substr(0, whole.size() - 300));
  EXPECT_EQ(open_volume(folder / "frames", {}).error().status, Status::truncated);
  ImportOptions options;
  options.allowed.add(Allowance::truncated);
  volume = open_volume(folder / "frames", options);
  ASSERT_TRUE(volume) << volume.error().message;
  const auto values = test::read_all(*volume->source);
  const size_t slice = series.pixels(0).size();
  for (size_t i = 0; i < slice; ++i) {
    EXPECT_EQ(values[10 * slice + i], series.pixels(10)[i]);
    EXPECT_TRUE(std::isnan(values[11 * slice + i]));
  }
}

TEST(DicomPixels, LosslessCodecsGiveTheSameValues) {
  using Type = gdcm::TransferSyntax;
  for (const auto type : {Type::JPEGLosslessProcess14_1, Type::JPEGLosslessProcess14,
                          Type::JPEG2000Lossless, Type::JPEGLSLossless, Type::RLELossless}) {
    for (const bool is_signed : {false, true}) {
      SCOPED_TRACE(gdcm::TransferSyntax::GetTSString(type));
      const TempFolder folder;
      BallSeries series;
      series.is_signed = is_signed;
      series.stored = is_signed ? 16 : 12;
      if (is_signed) series.add = -700;
      series.write(folder);
      for (int z = 0; z < series.size.z; ++z) {
        ASSERT_TRUE(encode(folder / series.file_name(z), type));
      }
      auto volume = open_volume(folder.path(), {});
      ASSERT_TRUE(volume) << volume.error().message;
      expect_field(*volume, series);
    }
  }
}

TEST(DicomPixels, DamagedCodecDataIsAnError) {
  const TempFolder folder;
  const BallSeries series;
  series.write(folder);
  const auto path = folder / series.file_name(0);
  ASSERT_TRUE(encode(path, gdcm::TransferSyntax::JPEGLosslessProcess14_1));
  const std::string whole = test::read_file(path);
  for (size_t at = whole.size() - 400; at < whole.size(); at += 37) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x55);
    write_file(path, changed);
    auto volume = open_volume(folder.path(), {});
    if (!volume) {
      EXPECT_EQ(volume.error().message.find('\n'), std::string::npos);
      continue;
    }
    std::vector<std::byte> out(2 * 20 * 17 * 12);
    const auto read = volume->source->read_slices(0, 12, out);
    if (read) continue;
    EXPECT_EQ(read.error().message.find('\n'), std::string::npos);
  }
}

TEST(DicomPixels, UnknownSyntaxesAreNamed) {
  const TempFolder folder;
  BallSeries series;
  series.syntax.uid = "1.2.840.10008.1.2.4.201";
  for (int z = 0; z < series.size.z; ++z) {
    DicomItem data = series.slice(z);
    data[0x7fe00010] = test::dicom_fragments({"what comes in future"});
    series.write_slice(folder, z, data);
  }
  const auto volume = open_volume(folder.path(), {});
  ASSERT_FALSE(volume);
  EXPECT_EQ(volume.error().status, Status::unsupported_format);
  EXPECT_NE(volume.error().message.find("1.2.840.10008.1.2.4.201"), std::string::npos);
}

TEST(DicomElements, EveryTruncationOfAFileIsAnErrorOrHasMissingPixels) {
  const TempFolder folder;
  const BallSeries series;
  for (const bool undefined : {false, true}) {
    for (test::DicomSyntax syntax : {test::DicomSyntax{}, test::implicit_little(),
                                     test::explicit_big(), test::deflated_little()}) {
      syntax.undefined_lengths = undefined;
      const std::string whole = DicomWriter(syntax).file(series.enhanced({0, 1, 2}));
      const size_t pixels = 3 * 2 * 20 * 17;
      const size_t head = syntax.deflated ? whole.size() : whole.size() - pixels;
      for (size_t size = 132; size < head; size += 11) {
        write_file(folder / "a.dcm", whole.substr(0, size));
        const auto volume = open_volume(folder / "a.dcm", {});
        if (!volume) continue;
        std::vector<std::byte> out(pixels);
        EXPECT_FALSE(volume->source->read_slices(0, 3, out)) << size;
      }
    }
  }
}

TEST(DicomElements, EveryFlippedByteIsAVolumeOrAnError) {
  const TempFolder folder;
  const BallSeries series;
  const std::string whole = DicomWriter({}).file(series.enhanced({0, 1, 2}));
  for (size_t at = 128; at + 3 * 2 * 20 * 17 < whole.size(); at += 2) {
    for (const char flip : {'\x01', '\xff'}) {
      std::string changed = whole;
      changed[at] = static_cast<char>(changed[at] ^ flip);
      write_file(folder / "a.dcm", changed);
      auto volume = open_volume(folder / "a.dcm", {});
      if (volume) {
        test::read_all(*volume->source);
      } else {
        EXPECT_EQ(volume.error().message.find('\n'), std::string::npos);
      }
    }
  }
}

TEST(DicomElements, LargeLengthsAllocateNothing) {
  const TempFolder folder;
  const BallSeries series;
  const DicomItem data = series.slice(0);
  std::string file = DicomWriter({}).file(data);
  const size_t rows = file.find(std::string("\x28\0\x10\0US", 6));
  ASSERT_NE(rows, std::string::npos);
  for (const char* vr : {"UN", "OB", "SQ"}) {
    std::string changed = file;
    changed.insert(rows,
                   std::string("\x20\0\x99\x99", 4) + vr + std::string("\0\0\xf0\xff\xff\x7f", 6));
    write_file(folder / "a.dcm", changed);
    const auto elements = dicom::read_elements(folder / "a.dcm");
    ASSERT_FALSE(elements);
    EXPECT_EQ(elements.error().status, Status::truncated) << elements.error().message;
  }
}

}  // namespace
}  // namespace isosplat::import
