#include <bzlib.h>
#include <lzma.h>
#include <zstd.h>

#include <algorithm>

#include "shared/import/codecs/packing.h"
#include "shared/import/open_volume.h"
#include "shared/import/volume/volume_name.h"
#include "tests/native/import_checks.h"

// Volumes that are compressed as a whole, by any of four programs.
namespace isosplat::import {
namespace {

using test::bytes_of;
using test::error_of;
using test::expect_error;
using test::nrrd_header;
using test::open;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

std::string gzip(const std::string& text) {
  return test::deflated(text);
}

std::string bzip2(const std::string& text) {
  std::string out(text.size() + text.size() / 50 + 1000, '\0');
  auto size = static_cast<unsigned>(out.size());
  BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(text.data()),
                           static_cast<unsigned>(text.size()), 9, 0, 0);
  return out.substr(0, size);
}

std::string xz(const std::string& text) {
  std::string out(lzma_stream_buffer_bound(text.size()), '\0');
  size_t size = 0;
  EXPECT_EQ(lzma_easy_buffer_encode(6, LZMA_CHECK_CRC64, nullptr,
                                    reinterpret_cast<const uint8_t*>(text.data()), text.size(),
                                    reinterpret_cast<uint8_t*>(out.data()), &size, out.size()),
            LZMA_OK);
  return out.substr(0, size);
}

std::string zstd(const std::string& text) {
  std::string out(ZSTD_compressBound(text.size()), '\0');
  return out.substr(0, ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 3));
}

struct Packer {
  const char* suffix;
  Packing packing;
  std::string (*pack)(const std::string&);
};

const Packer kPackers[] = {{".gz", Packing::gzip, gzip},
                           {".bz2", Packing::bzip2, bzip2},
                           {".xz", Packing::xz, xz},
                           {".zst", Packing::zstd, zstd}};

std::string nrrd() {
  return nrrd_header(kSize, "short", "spacings: 1 2 3\nendian: little\nencoding: raw\n\n") +
         bytes_of(pattern_voxels<int16_t>(kSize));
}

std::string npy() {
  std::string header = "{'descr': '<i2', 'fortran_order': False, 'shape': (3, 4, 5), }";
  header.resize(117, ' ');
  return std::string("\x93NUMPY\1\0\x76\0", 10) + header + "\n" +
         bytes_of(pattern_voxels<int16_t>(kSize));
}

std::string vtk() {
  return "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n"
         "SPACING 1 2 3\nORIGIN 0 0 0\nPOINT_DATA 60\nSCALARS p short\nLOOKUP_TABLE default\n" +
         bytes_of(test::byte_swapped(pattern_voxels<int16_t>(kSize)));
}

std::string nifti() {
  test::NiftiFile file;
  file.sizes = {5, 4, 3};
  file.rows = {{{-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, 1, 0}}};
  file.voxels = bytes_of(pattern_voxels<int16_t>(kSize));
  return file.bytes();
}

std::string meta_image() {
  return "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementSpacing = 1 1 1\n"
         "ElementType = MET_SHORT\nElementDataFile = LOCAL\n" +
         bytes_of(pattern_voxels<int16_t>(kSize));
}

std::string raw() {
  return bytes_of(pattern_voxels<int16_t>(kSize));
}

const std::pair<const char*, std::string (*)()> kVolumes[] = {
    {"v.nrrd", nrrd}, {"v.npy", npy},        {"v.vtk", vtk},
    {"v.nii", nifti}, {"v.mha", meta_image}, {"v_5x4x3_int16.raw", raw}};

TEST(PackedVolumes, EveryFormatIsReadFromEveryPacking) {
  for (const Packer& packer : kPackers) {
    for (const auto& [name, volume] : kVolumes) {
      const TempFolder folder;
      const auto path = folder / (std::string(name) + packer.suffix);
      SCOPED_TRACE(path.filename());
      write_file(path, packer.pack(volume()));
      auto opened = open(path);
      ASSERT_TRUE(opened.source);
      EXPECT_EQ(read_all(*opened.source), pattern_voxels<double>(kSize));
      EXPECT_EQ(opened.source->files(), std::vector{path});
      for (const std::string& note : opened.notes) {
        EXPECT_EQ(note.find("isosplat-"), note.npos) << note;
      }
    }
  }
}

TEST(PackedVolumes, TheContentDecidesNotTheName) {
  const TempFolder folder;
  for (const Packer& packer : kPackers) {
    write_file(folder / "v.nrrd", packer.pack(nrrd()));
    EXPECT_EQ(read_all(*open(folder / "v.nrrd").source), pattern_voxels<double>(kSize));
    EXPECT_EQ(packing_of_file(folder / "v.nrrd"), name_of(packer.packing));
  }
  write_file(folder / "v.nrrd", nrrd());
  EXPECT_EQ(packing_of_file(folder / "v.nrrd"), "");
  write_file(folder / "v.nii.gz", gzip(nifti()));
  EXPECT_EQ(packing_of_file(folder / "v.nii.gz"), "");  // its reader decompresses it
  EXPECT_EQ(volume_name("a/head.nii.bz2"), "head");
  EXPECT_EQ(volume_name("a/head.nrrd.zst"), "head");
}

TEST(PackedVolumes, SeveralStreamsFollowEachOther) {
  const TempFolder folder;
  const std::string whole = nrrd();
  for (const Packer& packer : kPackers) {
    write_file(folder / "v.nrrd", packer.pack(whole.substr(0, 90)) + packer.pack(whole.substr(90)));
    EXPECT_EQ(read_all(*open(folder / "v.nrrd").source), pattern_voxels<double>(kSize))
        << packer.suffix;
  }
}

TEST(PackedVolumes, DamagedAndCutFilesAreErrors) {
  const TempFolder folder;
  const auto path = folder / "v.nrrd.packed";
  for (const Packer& packer : kPackers) {
    const std::string whole = packer.pack(nrrd());
    for (size_t cut = 1; cut + 20 < whole.size(); cut += 9) {
      write_file(path, whole.substr(0, whole.size() - cut));
      EXPECT_NE(error_of(path), "") << packer.suffix << cut;
    }
    size_t noticed = 0, tried = 0;
    for (size_t at = 20; at + 12 < whole.size(); at += 7) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
      write_file(path, damaged);
      ++tried;
      const auto volume = open_volume(path, {});
      if (!volume || read_all(*volume->source) == pattern_voxels<double>(kSize)) ++noticed;
    }
    // By default, the zstd library writes no checksum.
    if (packer.packing != Packing::zstd) {
      EXPECT_EQ(noticed, tried) << packer.suffix;
    }
    write_file(path, whole.substr(0, 14));
    EXPECT_NE(error_of(path), "") << packer.suffix;
  }
}

TEST(PackedVolumes, RefusedContentIsNamedBeforeAllOfItIsUnpacked) {
  const TempFolder folder;
  const std::string zeros(64 << 20, '\0');
  for (const Packer& packer : kPackers) {
    write_file(folder / "v.packed", packer.pack(zeros));
    expect_error(folder / "v.packed", "no known signature");
    std::string tar(512, '\0');
    tar.replace(257, 5, "ustar");
    write_file(folder / "v.tar.packed", packer.pack(tar));
    expect_error(folder / "v.tar.packed", "a tar archive: unpack it with tar -xf");
    EXPECT_NE(error_of(folder / "v.tar.packed").find((folder / "v.tar.packed").string()),
              std::string::npos);
    write_file(folder / "twice", packer.pack(kPackers[1].pack(nrrd())));
    if (packer.packing != Packing::gzip) expect_error(folder / "twice", "compressed once");
  }
}

TEST(PackedVolumes, NothingIsLeftInTheTemporaryFolder) {
  const TempFolder folder, temporary;
  const char* before = std::getenv("TMPDIR");
  const std::string old = before ? before : "";
  ::setenv("TMPDIR", temporary.path().c_str(), 1);
  write_file(folder / "v.nrrd.bz2", bzip2(nrrd()));
  {
    const auto volume = open(folder / "v.nrrd.bz2");
    EXPECT_FALSE(std::filesystem::is_empty(temporary.path()));
  }
  EXPECT_TRUE(std::filesystem::is_empty(temporary.path()));
  write_file(folder / "v.nrrd.bz2", bzip2("NRRD0004\nnonsense"));
  EXPECT_NE(error_of(folder / "v.nrrd.bz2"), "");
  EXPECT_TRUE(std::filesystem::is_empty(temporary.path()));
  if (before) {
    ::setenv("TMPDIR", old.c_str(), 1);
  } else {
    ::unsetenv("TMPDIR");
  }
}

}  // namespace
}  // namespace isosplat::import
