// The decompression of DICOM pixels without a library, against GDCM: the same pixels.
#include <random>

#include "shared/import/dicom/codec.h"
#include "shared/import/dicom/lossless_jpeg.h"
#include "shared/import/dicom/pixels.h"
#include "tests/native/dicom_encode.h"
#include "tests/native/dicom_files.h"

namespace isosplat::import {
namespace {

using test::BallSeries;
using test::TempFolder;

struct Decoded {
  Result<void> result;
  std::vector<std::byte> pixels;
};

/// The first frame of a file by both. Nothing if the file's elements cannot be read.
std::optional<std::pair<Decoded, Decoded>> decode_with_both(const std::filesystem::path& path) {
  const auto elements = dicom::read_elements(path);
  dicom::Collection collection;
  if (!elements || !dicom::add_frames(*elements, path, collection) || collection.images.empty()) {
    return std::nullopt;
  }
  const dicom::Image& image = collection.images[0];
  if (!image.is_encapsulated || !image.obstacle.empty()) return std::nullopt;
  const dicom::EncodedFrame frame{&image, 0};
  const auto bytes = static_cast<size_t>(dicom::stored_frame_bytes(image));
  Decoded gdcm{{}, std::vector<std::byte>(bytes)}, plain{{}, std::vector<std::byte>(bytes)};
  std::vector<bool> absent;
  gdcm.result =
      dicom::decompress_with_gdcm({&frame, 1}, false, uint64_t{1} << 30, gdcm.pixels, absent);
  plain.result = dicom::decompress_plainly({&frame, 1}, false, plain.pixels, absent);
  return std::pair(std::move(gdcm), std::move(plain));
}

void expect_same(const std::filesystem::path& path) {
  const auto both = decode_with_both(path);
  ASSERT_TRUE(both);
  const auto& [gdcm, plain] = *both;
  ASSERT_TRUE(gdcm.result) << gdcm.result.error().message;
  ASSERT_TRUE(plain.result) << plain.result.error().message;
  EXPECT_TRUE(plain.pixels == gdcm.pixels);
}

TEST(PlainDicomCodec, RunLengthsAndLosslessJpegHaveThePixelsOfGdcm) {
  using Type = gdcm::TransferSyntax;
  for (const auto type :
       {Type::JPEGLosslessProcess14_1, Type::JPEGLosslessProcess14, Type::RLELossless}) {
    for (const bool is_signed : {false, true}) {
      for (const int stored : {8, 12, 16}) {
        SCOPED_TRACE(
            fmt::format("{}, {} bits, signed: {}", Type::GetTSString(type), stored, is_signed));
        const TempFolder folder;
        BallSeries series;
        series.is_signed = is_signed;
        series.stored = stored;
        if (stored == 8) series.slope = 16;
        if (is_signed) series.add = -700;
        series.write_slice(folder, 5, series.slice(5));
        const auto path = folder / series.file_name(5);
        ASSERT_TRUE(test::encode(path, type));
        expect_same(path);
      }
    }
  }
}

/// Writes lossless JPEG with codes of five bits for all sizes of differences.
class JpegWriter {
 public:
  JpegWriter(int bits, int predictor, int shift, size_t restart_rows)
      : bits_(bits), predictor_(predictor), shift_(shift), restart_rows_(restart_rows) {}

  std::string write(const std::vector<uint16_t>& samples, size_t columns) {
    const size_t rows = samples.size() / columns;
    out_ = "\xff\xd8";
    segment(0xc3, {bits_, static_cast<int>(rows >> 8), static_cast<int>(rows & 255),
                   static_cast<int>(columns >> 8), static_cast<int>(columns & 255), 1, 1, 0x11, 0});
    std::vector<int> table(17, 0);
    table[5] = 17;
    for (int symbol = 0; symbol < 17; ++symbol) table.push_back(symbol);
    segment(0xc4, table);
    const auto interval = static_cast<int>(restart_rows_ * columns);
    if (interval > 0) segment(0xdd, {interval >> 8, interval & 255});
    segment(0xda, {1, 1, 0, predictor_, 0, shift_});
    size_t first = 0;
    int restarts = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      const size_t x = i % columns, y = i / columns;
      if (restart_rows_ > 0 && x == 0 && y > 0 && y % restart_rows_ == 0) {
        flush();
        out_ += {'\xff', static_cast<char>(0xd0 + restarts++ % 8)};
        first = y;
      }
      const auto at = [&](size_t back) { return samples[i - back] >> shift_; };
      int guess = 1 << (bits_ - shift_ - 1);
      if (x > 0 && y == first) guess = at(1);
      if (x == 0 && y > first) guess = at(columns);
      if (x > 0 && y > first) {
        const int a = at(1), b = at(columns), c = at(columns + 1);
        const int guesses[] = {
            0, a, b, c, a + b - c, a + ((b - c) >> 1), b + ((a - c) >> 1), (a + b) >> 1};
        guess = guesses[predictor_];
      }
      put_difference(static_cast<int16_t>((samples[i] >> shift_) - guess));
    }
    flush();
    return out_ + "\xff\xd9";
  }

 private:
  void segment(int marker, const std::vector<int>& bytes) {
    const size_t length = bytes.size() + 2;
    out_ += {'\xff', static_cast<char>(marker), static_cast<char>(length >> 8),
             static_cast<char>(length & 255)};
    for (const int byte : bytes) out_ += static_cast<char>(byte);
  }

  void put_difference(int value) {
    if (value == -32768) return put(16, 5);
    int size = 0;
    while (std::abs(value) >> size) ++size;
    put(size, 5);
    put(value < 0 ? value + (1 << size) - 1 : value, size);
  }

  void put(int value, int count) {
    for (int i = count - 1; i >= 0; --i) {
      byte_ = byte_ << 1 | (value >> i & 1);
      if (++used_ == 8) put_byte();
    }
  }

  void put_byte() {
    out_ += static_cast<char>(byte_);
    if (byte_ == 255) out_ += '\0';
    byte_ = used_ = 0;
  }

  void flush() {
    while (used_ > 0) put(1, 1);
  }

  int bits_, predictor_, shift_;
  size_t restart_rows_;
  std::string out_;
  int byte_ = 0, used_ = 0;
};

std::vector<uint16_t> noisy_samples(int bits, int shift, size_t count) {
  std::mt19937 random(static_cast<uint32_t>(bits));
  std::vector<uint16_t> samples;
  for (size_t i = 0; i < count; ++i) {
    const auto value = i % 7 == 0 ? random() : static_cast<uint32_t>(i * 3);
    samples.push_back(static_cast<uint16_t>((value & ((1u << bits) - 1)) >> shift << shift));
  }
  return samples;
}

std::vector<uint8_t> bytes_in(const std::string& text) {
  return {text.begin(), text.end()};
}

TEST(LosslessJpeg, EveryPredictorPrecisionShiftAndRestartGivesTheSamples) {
  constexpr size_t kColumns = 33, kRows = 20;
  for (int predictor = 1; predictor <= 7; ++predictor) {
    for (const int bits : {2, 8, 12, 16}) {
      for (const int shift : {0, 1}) {
        for (const size_t restart_rows : {0, 1, 7}) {
          SCOPED_TRACE(fmt::format("predictor {}, {} bits, shift {}, restart after {} rows",
                                   predictor, bits, shift, restart_rows));
          const auto samples = noisy_samples(bits, shift, kColumns * kRows);
          JpegWriter writer(bits, predictor, shift, restart_rows);
          const auto picture = bytes_in(writer.write(samples, kColumns));
          std::vector<uint16_t> out(samples.size());
          EXPECT_EQ(decode_lossless_jpeg(picture, kColumns, out), bits);
          EXPECT_TRUE(out == samples);
        }
      }
    }
  }
}

TEST(LosslessJpeg, TruncatedAndDamagedPicturesAreRefusedOrDecoded) {
  const auto samples = noisy_samples(12, 0, 33 * 20);
  JpegWriter writer(12, 4, 0, 5);
  const auto picture = bytes_in(writer.write(samples, 33));
  std::vector<uint16_t> out(samples.size());
  for (size_t size = 0; size + 3 < picture.size(); ++size) {
    EXPECT_EQ(decode_lossless_jpeg(std::span(picture).first(size), 33, out), 0) << size;
  }
  std::mt19937 random(5);
  for (int i = 0; i < 5000; ++i) {
    auto changed = picture;
    for (int flips = 0; flips < 4; ++flips) {
      changed[random() % (i % 2 ? 60 : changed.size())] = static_cast<uint8_t>(random());
    }
    const int bits = decode_lossless_jpeg(changed, 33, out);
    EXPECT_TRUE(bits == 0 || (bits >= 2 && bits <= 16));
  }
  // Sizes other than the header's.
  EXPECT_EQ(decode_lossless_jpeg(picture, 20, out), 0);
  out.resize(33 * 19);
  EXPECT_EQ(decode_lossless_jpeg(picture, 33, out), 0);
}

TEST(PlainDicomCodec, DamagedRunLengthsAreRefused) {
  const TempFolder folder;
  const BallSeries series;
  series.write_slice(folder, 5, series.slice(5));
  const auto path = folder / series.file_name(5);
  ASSERT_TRUE(test::encode(path, gdcm::TransferSyntax::RLELossless));
  const std::string whole = test::read_file(path);
  const size_t head = whole.find(std::string("\2\0\0\0\x40\0\0\0", 8));
  ASSERT_NE(head, std::string::npos);
  for (size_t at = 0; at < 12; ++at) {
    for (const char byte : {'\0', '\x7f', '\xff'}) {
      std::string changed = whole;
      if (changed[head + at] == byte) continue;
      changed[head + at] = byte;
      test::write_file(path, changed);
      const auto both = decode_with_both(path);
      ASSERT_TRUE(both);
      EXPECT_FALSE(both->second.result && at < 4) << "the number of segments";
    }
  }
}

TEST(PlainDicomCodec, OtherSyntaxesNameTheProgram) {
  const TempFolder folder;
  const BallSeries series;
  series.write_slice(folder, 5, series.slice(5));
  const auto path = folder / series.file_name(5);
  ASSERT_TRUE(test::encode(path, gdcm::TransferSyntax::JPEG2000Lossless));
  const auto both = decode_with_both(path);
  ASSERT_TRUE(both);
  ASSERT_FALSE(both->second.result);
  EXPECT_EQ(both->second.result.error().status, Status::unsupported_format);
  EXPECT_NE(both->second.result.error().message.find("isosplat build"), std::string::npos);
}

}  // namespace
}  // namespace isosplat::import
