// Compares the TIFF reader without a library with libtiff: the same pages, pixels and errors.
#include <gtest/gtest.h>
#include <tiffio.h>

#include <random>

#include "shared/import/tiff/file.h"
#include "shared/import/tiff/pages.h"
#include "tests/native/import_checks.h"

namespace isosplat::import {
namespace {

using test::read_file;
using test::TempFolder;
using test::write_file;

/// How a page is written.
struct Form {
  uint16_t bits = 16, format = SAMPLEFORMAT_UINT;
  uint16_t compression = COMPRESSION_NONE, predictor = 1;
  uint32_t width = 61, height = 43;
  uint32_t rows_per_strip = 7;
  bool tiled = false;
  uint16_t fill_order = FILLORDER_MSB2LSB;
  const char* mode = "wl";
};

std::string text_of(const Form& form) {
  return fmt::format("{} bits, format {}, compression {}, predictor {}, {} × {}, {} rows, {}, {}",
                     form.bits, form.format, form.compression, form.predictor, form.width,
                     form.height, form.rows_per_strip, form.tiled ? "tiles" : "strips", form.mode);
}

/// Runs, copies and noise: all codes of the compressions occur.
std::vector<uint8_t> mixed_bytes(size_t count) {
  std::mt19937 random(static_cast<uint32_t>(count));
  std::vector<uint8_t> bytes;
  while (bytes.size() < count) {
    const size_t length = 1 + random() % 200, back = 1 + random() % 3000;
    const auto kind = random() % 4;
    for (size_t i = 0; i < length; ++i) {
      const bool copies = kind > 0 && bytes.size() >= back;
      bytes.push_back(copies ? bytes[bytes.size() - (kind == 1 ? 1 : back)]
                             : static_cast<uint8_t>(random() % (kind == 0 ? 256 : 3)));
    }
  }
  bytes.resize(count);
  return bytes;
}

void write_page(const std::filesystem::path& path, const Form& form) {
  TIFF* tiff = TIFFOpen(path.c_str(), form.mode);
  ASSERT_TRUE(tiff);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, form.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, form.height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, form.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, form.format);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, form.compression);
  TIFFSetField(tiff, TIFFTAG_FILLORDER, form.fill_order);
  TIFFSetField(tiff, TIFFTAG_XRESOLUTION, 3.7);
  TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, "a page");
  if (form.predictor > 1) TIFFSetField(tiff, TIFFTAG_PREDICTOR, form.predictor);
  if (form.tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 32);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
    for (uint32_t tile = 0; tile < TIFFNumberOfTiles(tiff); ++tile) {
      auto bytes = mixed_bytes(static_cast<size_t>(TIFFTileSize(tiff)));
      ASSERT_GT(TIFFWriteEncodedTile(tiff, tile, bytes.data(), TIFFTileSize(tiff)), 0);
    }
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, form.rows_per_strip);
    const auto row = static_cast<size_t>(TIFFScanlineSize(tiff));
    auto bytes = mixed_bytes(row * form.height);
    for (uint32_t y = 0; y < form.height; ++y) {
      ASSERT_EQ(TIFFWriteScanline(tiff, bytes.data() + y * row, y), 1);
    }
  }
  TIFFClose(tiff);
}

/// The first page of a file. Nothing if it cannot be read.
struct Outcome {
  TiffPage page;
  bool is_whole = false;
  std::optional<std::vector<std::byte>> pixels;
};

std::optional<Outcome> read_page(std::unique_ptr<TiffFile> file, uint64_t directory) {
  const auto page = file ? file->go_to(directory) : std::nullopt;
  if (!page) return std::nullopt;
  Outcome outcome{*page, file->is_whole(), {}};
  const uint64_t pixels = static_cast<uint64_t>(page->width) * static_cast<uint64_t>(page->height);
  if (!page->unknown.empty() || page->samples != 1 || pixels > 1 << 20) return outcome;
  std::vector<std::byte> out(static_cast<size_t>(pixels) * voxel_bytes(page->type));
  if (page->undecodable.empty() && file->read(out)) outcome.pixels = std::move(out);
  return outcome;
}

/// The first page by both readers.
std::pair<std::optional<Outcome>, std::optional<Outcome>> read_with_both(
    const std::filesystem::path& path) {
  const auto pages = find_tiff_pages(path);
  if (!pages) return {};
  return {read_page(open_libtiff(path), pages->offsets[0]),
          read_page(open_plain_tiff(path), pages->offsets[0])};
}

void expect_same(const std::filesystem::path& path) {
  const auto [library, plain] = read_with_both(path);
  ASSERT_TRUE(library && plain);
  EXPECT_TRUE(plain->page.same_kind(library->page));
  EXPECT_EQ(plain->page.description, library->page.description);
  EXPECT_EQ(plain->page.pixels_per_unit_x, library->page.pixels_per_unit_x);
  EXPECT_EQ(plain->page.pixels_per_unit_y, library->page.pixels_per_unit_y);
  EXPECT_EQ(plain->page.uncompressed_at, library->page.uncompressed_at);
  EXPECT_EQ(plain->is_whole, library->is_whole);
  ASSERT_TRUE(library->pixels && plain->pixels);
  EXPECT_TRUE(*plain->pixels == *library->pixels);
}

TEST(PlainTiff, ReadsEveryTypeCompressionPredictorAndByteOrder) {
  const TempFolder folder;
  for (const char* mode : {"wl", "wb", "wl8", "wb8"}) {
    for (const uint16_t bits : {8, 16, 32, 64}) {
      for (const uint16_t format : {SAMPLEFORMAT_UINT, SAMPLEFORMAT_INT, SAMPLEFORMAT_IEEEFP}) {
        if (format == SAMPLEFORMAT_IEEEFP && bits < 32) continue;
        for (const uint16_t compression :
             {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE,
              COMPRESSION_PACKBITS}) {
          const bool predicts =
              compression != COMPRESSION_NONE && compression != COMPRESSION_PACKBITS;
          for (uint16_t predictor = 1; predictor <= (predicts ? 3 : 1); ++predictor) {
            if (predictor == 3 && format != SAMPLEFORMAT_IEEEFP) continue;
            for (const bool tiled : {false, true}) {
              Form form{bits, format, compression, predictor};
              form.tiled = tiled;
              form.mode = mode;
              SCOPED_TRACE(text_of(form));
              write_page(folder / "a.tif", form);
              expect_same(folder / "a.tif");
            }
          }
        }
      }
    }
  }
}

TEST(PlainTiff, ReadsStripsOfEverySizeAndReversedBits) {
  const TempFolder folder;
  for (const uint16_t compression :
       {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    for (const uint16_t fill_order : {FILLORDER_MSB2LSB, FILLORDER_LSB2MSB}) {
      for (const uint32_t width : {1u, 3u, 700u}) {
        for (const uint32_t rows : {1u, 43u, 1000u, 0xffffffffu}) {
          Form form;
          form.compression = compression;
          form.width = width;
          form.rows_per_strip = rows;
          form.fill_order = fill_order;
          SCOPED_TRACE(text_of(form));
          write_page(folder / "a.tif", form);
          expect_same(folder / "a.tif");
        }
      }
    }
  }
}

TEST(PlainTiff, EveryTruncationIsFoundAsLibtiffFindsIt) {
  const TempFolder folder;
  for (const bool tiled : {false, true}) {
    for (const uint16_t compression : {COMPRESSION_NONE, COMPRESSION_LZW}) {
      Form form;
      form.compression = compression;
      form.tiled = tiled;
      form.height = 20;
      write_page(folder / "whole.tif", form);
      const std::string whole = read_file(folder / "whole.tif");
      for (size_t size = 8; size < whole.size(); size += 131) {
        SCOPED_TRACE(fmt::format("{}, {} bytes", text_of(form), size));
        write_file(folder / "a.tif", whole.substr(0, size));
        const auto [library, plain] = read_with_both(folder / "a.tif");
        ASSERT_EQ(plain.has_value(), library.has_value());
        if (!plain) continue;
        EXPECT_EQ(plain->is_whole, library->is_whole);
        EXPECT_EQ(plain->pixels.has_value(), library->pixels.has_value());
      }
    }
  }
}

TEST(PlainTiff, DamagedStripsAreAnErrorOrHaveTheSamePixels) {
  const TempFolder folder;
  std::mt19937 random(3);
  for (const uint16_t compression :
       {COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    Form form;
    form.compression = compression;
    write_page(folder / "whole.tif", form);
    const std::string whole = read_file(folder / "whole.tif");
    for (int i = 0; i < 300; ++i) {
      std::string changed = whole;
      for (int flips = 0; flips < 3; ++flips) {
        changed[8 + random() % (whole.size() - 8)] = static_cast<char>(random());
      }
      write_file(folder / "a.tif", changed);
      const auto [library, plain] = read_with_both(folder / "a.tif");
      // If deflated data are longer than the strip, libtiff ignores the rest.
      if (compression == COMPRESSION_ADOBE_DEFLATE || !library || !plain) continue;
      if (!library->pixels || !plain->pixels || !plain->page.same_kind(library->page)) continue;
      EXPECT_TRUE(*plain->pixels == *library->pixels) << text_of(form);
    }
  }
}

/// A little-endian file with one directory at byte 8. Each entry: tag, type, count, value.
std::string file_with(const std::vector<std::array<uint32_t, 4>>& entries, uint32_t next = 0) {
  std::string file("II\x2a\0\x08\0\0\0", 8);
  file += test::bytes_of(std::vector{static_cast<uint16_t>(entries.size())});
  for (const auto& [tag, type, count, value] : entries) {
    file += test::bytes_of(std::vector{static_cast<uint16_t>(tag), static_cast<uint16_t>(type)});
    file += test::bytes_of(std::vector{count, value});
  }
  return file + test::bytes_of(std::vector{next});
}

TEST(PlainTiff, HostileDirectoriesAllocateNothing) {
  const TempFolder folder;
  const auto path = folder / "a.tif";
  const auto read = [&](uint32_t width, uint32_t height, uint32_t compression, uint32_t rows,
                        uint32_t at, uint32_t bytes) {
    write_file(path, file_with({{256, 4, 1, width},
                                {257, 4, 1, height},
                                {258, 3, 1, 8},
                                {259, 3, 1, compression},
                                {273, 4, 1, at},
                                {278, 4, 1, rows},
                                {279, 4, 1, bytes}}));
    auto file = open_plain_tiff(path);
    if (!file || !file->go_to(8)) return false;
    return file->is_whole();
  };
  EXPECT_TRUE(read(4, 4, 1, 4, 8, 16)) << "a page that is read";
  for (const uint32_t compression : {1u, 5u, 8u, 32773u}) {
    SCOPED_TRACE(compression);
    EXPECT_FALSE(read(65535, 65535, compression, 65535, 8, 16)) << "4 GiB";
    EXPECT_FALSE(read(0xffffffff, 0xffffffff, compression, 0xffffffff, 8, 16));
    EXPECT_FALSE(read(0xffffffff, 0xffffffff, compression, 1, 8, 16)) << "4 billion strips";
    EXPECT_FALSE(read(4, 4, compression, 0, 8, 16)) << "strips without rows";
    EXPECT_FALSE(read(4, 4, compression, 4, 0xfffffff0, 16)) << "a strip outside of the file";
  }
  EXPECT_FALSE(read(0, 4, 1, 4, 8, 16));
  EXPECT_FALSE(read(4, 0, 1, 4, 8, 16));
  // Values outside of the file, and tiles of 2^32 × 2^32 pixels.
  for (const std::array<uint32_t, 4> entry : {std::array<uint32_t, 4>{270, 2, 0xffffffff, 8},
                                              {273, 4, 0x40000000, 8},
                                              {273, 16, 0xffffffff, 8}}) {
    write_file(path, file_with({{256, 4, 1, 4}, {257, 4, 1, 4}, {258, 3, 1, 8}, entry}));
    EXPECT_FALSE(open_plain_tiff(path)->go_to(8));
  }
  write_file(path, file_with({{256, 4, 1, 4},
                              {257, 4, 1, 4},
                              {258, 3, 1, 8},
                              {322, 4, 1, 0xffffffff},
                              {323, 4, 1, 0xffffffff},
                              {324, 4, 1, 8},
                              {325, 4, 1, 16}}));
  const auto tiles = open_plain_tiff(path);
  ASSERT_TRUE(tiles->go_to(8));
  std::vector<std::byte> out(16);
  EXPECT_FALSE(tiles->is_whole());
  EXPECT_FALSE(tiles->read(out));
}

TEST(PlainTiff, ChainsOfDirectoriesEndWhereTheyReturn) {
  const TempFolder folder;
  write_file(folder / "a.tif", file_with({{256, 4, 1, 4}, {257, 4, 1, 4}, {273, 4, 1, 8}}, 8));
  const auto pages = find_tiff_pages(folder / "a.tif");
  ASSERT_TRUE(pages);
  EXPECT_EQ(pages->offsets.size(), 1u);
  EXPECT_TRUE(pages->ends_early);
}

}  // namespace
}  // namespace isosplat::import
