#include <cstdio>  // jpeglib.h needs it
//
#include <jpeglib.h>
#include <openjpeg.h>
#include <png.h>

#include <cmath>

#include "tests/native/import_checks.h"

// Folders with a picture per slice. The pictures are written by the libraries of their formats.
namespace isosplat::import {
namespace {

using test::error_of;
using test::expect_error;
using test::expect_note;
using test::open;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr int kWidth = 13, kHeight = 11, kSlices = 12;

/// The sample of a voxel. bits: size of a sample, 8 or 16.
int sample_at(int x, int y, int z, int bits) {
  const int value = x + 3 * y + 7 * z + (bits == 16 ? 1000 * (x + y) : 0);
  return value & ((1 << bits) - 1);
}

struct Png {
  int bits = 8;
  int colours = PNG_COLOR_TYPE_GRAY;
  bool interlaced = false;
  int width = kWidth;
};

void write_png(const std::filesystem::path& path, int z, const Png& form) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(form.width), kHeight, form.bits, form.colours,
               form.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, 0, 0);
  if (form.colours == PNG_COLOR_TYPE_PALETTE) {
    const png_color palette[256] = {};
    png_set_PLTE(png, info, palette, 256);
  }
  png_write_info(png, info);
  if (form.bits == 16) png_set_swap(png);
  if (form.bits < 8) png_set_packing(png);
  const int channels = png_get_channels(png, info);
  std::vector<std::string> rows;
  for (int y = 0; y < kHeight; ++y) {
    std::string row;
    for (int x = 0; x < form.width; ++x) {
      for (int c = 0; c < channels; ++c) {
        const auto sample = static_cast<uint16_t>(sample_at(x, y, z, form.bits));
        row.append(reinterpret_cast<const char*>(&sample), form.bits == 16 ? 2 : 1);
      }
    }
    rows.push_back(row);
  }
  std::vector<png_bytep> pointers;
  for (std::string& row : rows) pointers.push_back(reinterpret_cast<png_bytep>(row.data()));
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

void write_jpeg(const std::filesystem::path& path, int z, int channels = 1) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  jpeg_stdio_dest(&jpeg, file);
  jpeg.image_width = kWidth;
  jpeg.image_height = kHeight;
  jpeg.input_components = channels;
  jpeg.in_color_space = channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < kHeight; ++y) {
    std::string row;
    for (int x = 0; x < kWidth * channels; ++x) {
      row += static_cast<char>(sample_at(x / channels, y, z, 8));
    }
    auto* pointer = reinterpret_cast<JSAMPROW>(row.data());
    jpeg_write_scanlines(&jpeg, &pointer, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::fclose(file);
}

void write_jpeg2000(const std::filesystem::path& path, int z, uint32_t bits, bool is_signed) {
  opj_cparameters_t parameters;
  opj_set_default_encoder_parameters(&parameters);
  parameters.numresolution = 2;
  opj_image_cmptparm_t component{};
  component.dx = component.dy = 1;
  component.w = kWidth;
  component.h = kHeight;
  component.prec = bits;
  component.sgnd = is_signed;
  opj_image_t* image = opj_image_create(1, &component, OPJ_CLRSPC_GRAY);
  image->x1 = kWidth;
  image->y1 = kHeight;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    image->comps[0].data[i] = sample_at(i % kWidth, i / kWidth, z, static_cast<int>(bits)) -
                              (is_signed ? 1 << (bits - 1) : 0);
  }
  const bool is_bare = path.extension() == ".j2k";
  opj_codec_t* codec = opj_create_compress(is_bare ? OPJ_CODEC_J2K : OPJ_CODEC_JP2);
  opj_setup_encoder(codec, &parameters, image);
  opj_stream_t* stream = opj_stream_create_default_file_stream(path.c_str(), OPJ_FALSE);
  EXPECT_TRUE(opj_start_compress(codec, image, stream) && opj_encode(codec, stream) &&
              opj_end_compress(codec, stream));
  opj_stream_destroy(stream);
  opj_destroy_codec(codec);
  opj_image_destroy(image);
}

/// Expects the samples, plus `add`, within `tolerance`.
void expect_samples(const TempFolder& folder, int bits, double add = 0, double tolerance = 0) {
  auto volume = open(folder.path());
  ASSERT_TRUE(volume.source);
  EXPECT_EQ(volume.source->header().grid.voxels, (Index3{kWidth, kHeight, kSlices}));
  const auto values = read_all(*volume.source);
  for (size_t i = 0; i < values.size(); ++i) {
    const int n = static_cast<int>(i);
    const int expected = sample_at(n % kWidth, n / kWidth % kHeight, n / kWidth / kHeight, bits);
    ASSERT_NEAR(values[i], expected + add, tolerance) << i;
  }
}

TEST(ImportImages, PngOfEachDepthAlsoInterlaced) {
  for (const int bits : {1, 2, 4, 8, 16}) {
    for (const bool interlaced : {false, true}) {
      SCOPED_TRACE(fmt::format("{} bits, interlaced: {}", bits, interlaced));
      const TempFolder folder;
      // Slice 10 must come after slice 9.
      for (int z = 0; z < kSlices; ++z) {
        write_png(folder / fmt::format("s{}.png", z), z, {bits, PNG_COLOR_TYPE_GRAY, interlaced});
      }
      expect_samples(folder, bits);
      expect_note(open(folder.path()), "--spacing sets another");
    }
  }
}

TEST(ImportImages, JpegWithANote) {
  const TempFolder folder;
  for (int z = 0; z < kSlices; ++z) write_jpeg(folder / fmt::format("s{}.jpg", z), z);
  expect_samples(folder, 8, 0, 3);
  expect_note(open(folder.path()), "JPEG does not keep samples exactly");
}

TEST(ImportImages, Jpeg2000Exactly) {
  for (const uint32_t bits : {8u, 12u, 16u}) {
    for (const bool is_signed : {false, true}) {
      for (const char* extension : {"jp2", "j2k"}) {
        SCOPED_TRACE(fmt::format("{} bits, signed: {}, {}", bits, is_signed, extension));
        const TempFolder folder;
        for (int z = 0; z < kSlices; ++z) {
          write_jpeg2000(folder / fmt::format("s{:03}.{}", z, extension), z, bits, is_signed);
        }
        expect_samples(folder, static_cast<int>(bits), is_signed ? -(1 << (bits - 1)) : 0);
      }
    }
  }
}

TEST(ImportImages, ColoursAreRefusedWithTheCommandThatHelps) {
  for (const int colours :
       {PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_PALETTE, PNG_COLOR_TYPE_GRAY_ALPHA}) {
    const TempFolder folder;
    for (int z = 0; z < 3; ++z) {
      write_png(folder / fmt::format("s{}.png", z), z, {8, colours});
    }
    expect_error(folder.path(), "mogrify -path");
  }
  const TempFolder folder;
  for (int z = 0; z < 3; ++z) write_jpeg(folder / fmt::format("s{}.jpg", z), z, 3);
  expect_error(folder.path(), "found 3 channels");
}

TEST(ImportImages, SlicesOfOtherSizesDamagedOnesAndGapsAreErrors) {
  const TempFolder folder;
  const auto write = [&](int z) { write_png(folder / fmt::format("s{}.png", z), z, {16}); };
  for (int z = 0; z < 4; ++z) write(z);
  write_png(folder / "s2.png", 2, {16, PNG_COLOR_TYPE_GRAY, false, kWidth + 1});
  expect_error(folder.path(), "expected a slice of 13 × 11");
  write_png(folder / "s2.png", 2, {8});
  expect_error(folder.path(), "of 8 bits");
  std::filesystem::remove(folder / "s2.png");
  expect_error(folder.path(), "--allow-gaps");
  ImportOptions options;
  options.allowed.add(Allowance::gaps);
  auto gap = open(folder.path(), options);
  const auto values = read_all(*gap.source);
  EXPECT_TRUE(std::isnan(values[2 * kWidth * kHeight]));
  EXPECT_EQ(values[3 * kWidth * kHeight + 1], sample_at(1, 0, 3, 16));

  write(2);
  const std::string whole = test::read_file(folder / "s2.png");
  for (size_t cut = 1; cut < whole.size(); cut += 5) {
    write_file(folder / "s2.png", whole.substr(0, whole.size() - cut));
    EXPECT_NE(error_of(folder.path()), "") << cut;
  }
  for (size_t at = 8; at < whole.size(); at += 3) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    write_file(folder / "s2.png", damaged);
    EXPECT_NE(error_of(folder.path()), "") << at;
  }
}

TEST(ImportImages, CutJpegsAreErrors) {
  for (const bool is_2000 : {false, true}) {
    const TempFolder folder;
    const std::string name = is_2000 ? "s{}.jp2" : "s{}.jpg";
    for (int z = 0; z < 2; ++z) {
      const auto path = folder / fmt::format(fmt::runtime(name), z);
      is_2000 ? write_jpeg2000(path, z, 16, false) : write_jpeg(path, z);
    }
    const auto last = folder / fmt::format(fmt::runtime(name), 1);
    const std::string whole = test::read_file(last);
    for (size_t kept : {whole.size() / 8, whole.size() / 2, whole.size() - 40}) {
      write_file(last, whole.substr(0, kept));
      EXPECT_NE(error_of(folder.path()), "") << kept << " of " << whole.size();
    }
  }
}

TEST(ImportImages, OnePictureIsNotAVolume) {
  const TempFolder folder;
  write_png(folder / "s.png", 0, {});
  expect_error(folder / "s.png", "a single image (PNG): give the folder with all slices");
  EXPECT_EQ(format_of_file(folder / "s.png"), "PNG");
}

}  // namespace
}  // namespace isosplat::import
