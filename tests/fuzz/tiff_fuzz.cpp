// TIFF files, as browsers read them: directories, descriptions, strips and tiles.
//
// If the first byte of the input is 128 or more, the rest is a file. Otherwise the byte is the
// number of a valid file, and the rest are edits of it.
#include <sys/mman.h>
#include <tiffio.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <vector>

#include "shared/import/tiff/file.h"
#include "shared/import/tiff/series.h"
#include "tests/fuzz/edits.h"

namespace isosplat::import {
namespace {

struct Form {
  uint16_t bits, format, compression, predictor;
  bool tiled;
  const char* mode;
};

/// Two pages of 20 × 9 voxels, written to an open file.
void write_pages(const char* path, const Form& form) {
  TIFF* tiff = TIFFOpen(path, form.mode);
  for (int page = 0; page < 2; ++page) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 20);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 9);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, form.bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, form.format);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, form.compression);
    if (form.predictor > 1) TIFFSetField(tiff, TIFFTAG_PREDICTOR, form.predictor);
    TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION,
                 "ImageJ=1.53t\nimages=2\nslices=2\nunit=mm\nspacing=3\n");
    if (form.tiled) {
      TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
      TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
    } else {
      TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 4);
    }
    const auto bytes =
        static_cast<size_t>(form.tiled ? TIFFTileSize(tiff) : TIFFScanlineSize(tiff));
    std::vector<uint8_t> voxels(bytes);
    for (size_t i = 0; i < bytes; ++i) voxels[i] = static_cast<uint8_t>(i * i / 7 % 9);
    for (uint32_t i = 0; i < (form.tiled ? TIFFNumberOfTiles(tiff) : 9u); ++i) {
      if (form.tiled) TIFFWriteEncodedTile(tiff, i, voxels.data(), TIFFTileSize(tiff));
      if (!form.tiled) TIFFWriteScanline(tiff, voxels.data(), i);
    }
    TIFFWriteDirectory(tiff);
  }
  TIFFClose(tiff);
}

std::string read_whole(const char* path) {
  std::string content;
  std::FILE* file = std::fopen(path, "rb");
  for (int c = 0; (c = std::fgetc(file)) != EOF;) content.push_back(static_cast<char>(c));
  std::fclose(file);
  return content;
}

std::vector<std::string> make_files(const char* path) {
  std::vector<std::string> files;
  for (const char* mode : {"wl", "wb", "wl8"}) {
    for (const bool tiled : {false, true}) {
      for (const Form& form :
           {Form{16, SAMPLEFORMAT_INT, COMPRESSION_NONE, 1, tiled, mode},
            Form{8, SAMPLEFORMAT_UINT, COMPRESSION_PACKBITS, 1, tiled, mode},
            Form{16, SAMPLEFORMAT_UINT, COMPRESSION_LZW, 2, tiled, mode},
            Form{32, SAMPLEFORMAT_IEEEFP, COMPRESSION_ADOBE_DEFLATE, 3, tiled, mode}}) {
        write_pages(path, form);
        files.push_back(read_whole(path));
      }
    }
  }
  return files;
}

void read_file(const std::filesystem::path& path) {
  const auto pages = find_tiff_pages(path);
  if (!pages) return;
  const auto file = open_plain_tiff(path);
  for (const uint64_t directory : pages->offsets) {
    const auto page = file ? file->go_to(directory) : std::nullopt;
    if (!page) continue;
    static_cast<void>(tiff_series(path, *pages, *page));
    static_cast<void>(file->is_whole());
    const auto pixels = static_cast<uint64_t>(page->width) * static_cast<uint64_t>(page->height);
    if (pixels > 1 << 20 || page->samples != 1 || !page->unknown.empty()) continue;
    std::vector<std::byte> out(static_cast<size_t>(pixels) * voxel_bytes(page->type));
    static_cast<void>(file->read(out));
  }
}

}  // namespace
}  // namespace isosplat::import

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isosplat;
  using namespace isosplat::import;
  static const int memory = memfd_create("tiff", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(memory);
  static const std::vector<std::string> files = make_files(path.c_str());
  fuzz::Input input(data, size);
  const uint32_t which = input.number(1);
  std::string file;
  if (which >= 128) {
    const auto rest = input.rest();
    file.assign(reinterpret_cast<const char*>(rest.data()), rest.size());
  } else {
    file = files[which % files.size()];
    if (which & 64) file.resize(input.number(2) % file.size());
    edit(std::as_writable_bytes(std::span(file)), input);
  }
  if (ftruncate(memory, 0) != 0) return 0;
  if (pwrite(memory, file.data(), file.size(), 0) != static_cast<ssize_t>(file.size())) return 0;
  read_file(path);
  return 0;
}
