#include "tests/native/volume_files.h"

namespace isosplat::import {
namespace {

using test::bytes_of;
using test::deflated;
using test::nrrd_header;
using test::pattern_voxels;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

/// The error of opening the file, or of reading it if only its compressed data are invalid.
Error error_of(const std::filesystem::path& path, const ImportOptions& options = {}) {
  auto volume = open_volume(path, options);
  if (!volume) return volume.error();
  const VolumeHeader& header = volume->source->header();
  const Index3 n = header.grid.voxels;
  if (int64_t{n.x} * n.y * n.z > 1000000) return {Status::ok, "opened a huge volume"};
  std::vector<std::byte> out(static_cast<size_t>(n.x * n.y * n.z) * voxel_bytes(header.type));
  const auto read = volume->source->read_slices(0, n.z, out);
  return read ? Error{Status::ok, "no error"} : read.error();
}

void expect_error(const std::filesystem::path& path, Status status, const std::string& part,
                  const ImportOptions& options = {}) {
  const Error error = error_of(path, options);
  EXPECT_EQ(status_name(error.status), status_name(status)) << error.message;
  EXPECT_NE(error.message.find(part), std::string::npos) << error.message;
  EXPECT_EQ(error.message.find('\n'), std::string::npos) << error.message;
  EXPECT_NE(error.message.find(path.filename().string()), std::string::npos) << error.message;
}

TEST(ImportErrors, FilesThatAreNotVolumes) {
  const TempFolder folder;
  expect_error(folder / "absent.nrrd", Status::io_error, "No such file");
  write_file(folder / "empty.nrrd", "");
  expect_error(folder / "empty.nrrd", Status::malformed_volume, "empty");
  write_file(folder / "text.nrrd", "this is not a volume\n");
  expect_error(folder / "text.nrrd", Status::unsupported_format, "expected NRRD");
  write_file(folder / "grid.vti", "<?xml version='1.0'?>\n<VTKFile type=\"ImageData\">\n");
  expect_error(folder / "grid.vti", Status::truncated, "expected </VTKFile>");
  write_file(
      folder / "name.vti",
      "<VTKFile type='ImageData'><ImageData WholeExtent='0 1 0 1 0 1'><Piece Extent='0 1 0 1 0 "
      "1'><PointData><DataArray type='Int8' Name='a&#10;b' format='ascii'>1 "
      "2</DataArray></PointData></Piece></ImageData></VTKFile>");
  expect_error(folder / "name.vti", Status::malformed_volume,
               "expected 8 values in the array 'a b', found 2");
  write_file(folder / "mesh.vtu", "<?xml version='1.0'?>\n<VTKFile type=\"UnstructuredGrid\">\n");
  expect_error(folder / "mesh.vtu", Status::unsupported_format, "VTK's XML format");
  write_file(folder / "store.dat", std::string("\x89ISOS\r\n\x1a", 8) + std::string(600, '\1'));
  expect_error(folder / "store.dat", Status::unsupported_format, "found a store: open it with");
  write_file(folder / "one.png", "\x89PNG\r\n\x1a\n" + std::string(600, '\1'));
  expect_error(folder / "one.png", Status::unsupported_format, "found a single image (PNG)");
  std::filesystem::create_directory(folder / "nothing");
  expect_error(folder / "nothing", Status::unsupported_format, "found an empty folder");
  std::filesystem::create_directory(folder / "letters");
  write_file(folder / "letters/a.txt", "hello");
  expect_error(folder / "letters", Status::unsupported_format, "found neither");
  write_file(folder / "v.raw", "12345678");
  expect_error(folder / "v.raw", Status::invalid_argument, "--dims 256x256x128 --type u8");
  write_file(folder / "fake.nii.gz", "not compressed");
  expect_error(folder / "fake.nii.gz", Status::unsupported_format,
               "begins with \"not compressed\"");
  write_file(folder / "mesh.vtk",
             "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 0 float\n");
  expect_error(folder / "mesh.vtk", Status::unsupported_format, "found polydata");
}

TEST(ImportErrors, HeadersThatDeclareMoreThanTheFileHas) {
  const TempFolder folder;
  const std::string data = bytes_of(pattern_voxels<uint8_t>(kSize));
  const std::string huge =
      "NRRD0004\ntype: double\ndimension: 3\nsizes: 1000000 1000000 1000000\nendian: little\n";
  write_file(folder / "short.nrrd",
             nrrd_header(kSize, "uint8", "encoding: raw\n\n") + data.substr(1));
  expect_error(folder / "short.nrrd", Status::truncated, "expected 60 bytes of voxels");
  write_file(folder / "huge.nrrd", huge + "encoding: raw\n\n" + data);
  expect_error(folder / "huge.nrrd", Status::truncated, "found 60");
  write_file(folder / "huge_gzip.nrrd", huge + "encoding: gzip\n\n" + deflated(data));
  expect_error(folder / "huge_gzip.nrrd", Status::truncated, "found at most");
  write_file(folder / "huge_text.nrrd", huge + "encoding: ascii\n\n1 2 3");
  expect_error(folder / "huge_text.nrrd", Status::truncated, "found at most");
  write_file(folder / "larger.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 5000000000 2 2\nencoding: raw\n\n");
  expect_error(folder / "larger.nrrd", Status::volume_too_large, "at most");
  write_file(folder / "gzip.nrrd",
             nrrd_header(kSize, "uint8", "encoding: gzip\n\n") + deflated(data.substr(7)));
  expect_error(folder / "gzip.nrrd", Status::truncated, "after decompression");
  const std::string cut = deflated(data);
  write_file(folder / "cut.nrrd",
             nrrd_header(kSize, "uint8", "encoding: gzip\n\n") + cut.substr(0, cut.size() / 2));
  expect_error(folder / "cut.nrrd", Status::truncated, "after decompression");
  std::string damaged = cut;
  damaged[12] = static_cast<char>(damaged[12] ^ 0x55);
  damaged[13] = static_cast<char>(damaged[13] ^ 0x55);
  write_file(folder / "damaged.nrrd", nrrd_header(kSize, "uint8", "encoding: gzip\n\n") + damaged);
  EXPECT_NE(error_of(folder / "damaged.nrrd").status, Status::ok);

  write_file(folder / "short.mha",
             "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_UCHAR\n"
             "ElementDataFile = LOCAL\n" +
                 data.substr(1));
  expect_error(folder / "short.mha", Status::truncated, "expected 60 bytes");
  write_file(folder / "short.vtk",
             "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n"
             "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 60\nSCALARS s unsigned_char\n"
             "LOOKUP_TABLE default\n" +
                 data.substr(1));
  expect_error(folder / "short.vtk", Status::truncated, "expected 60 bytes");
  test::NiftiFile nifti;
  nifti.sizes = {5, 4, 3};
  nifti.voxels = std::string(100, 'x');
  write_file(folder / "short.nii", nifti.bytes());
  expect_error(folder / "short.nii", Status::truncated, "expected 120 bytes");

  ImportOptions raw;
  raw.dims = {5, 4, 3};
  raw.type = VoxelType::u16;
  write_file(folder / "v.raw", data);
  expect_error(folder / "v.raw", Status::truncated, "voxels of 1 bytes would fit", raw);
  raw.dims = {1 << 20, 1 << 20, 1 << 20};
  expect_error(folder / "v.raw", Status::truncated, "found a file of 60 bytes", raw);
}

TEST(ImportErrors, EveryTruncationOfEveryFormatIsAnError) {
  const TempFolder folder;
  const std::string data = bytes_of(pattern_voxels<int16_t>(kSize));
  test::NiftiFile nifti;
  nifti.sizes = {5, 4, 3};
  nifti.voxels = data;
  const std::pair<std::string, std::string> files[] = {
      {"a.nrrd", nrrd_header(kSize, "short", "endian: little\nencoding: raw\n\n") + data},
      {"b.nrrd",
       nrrd_header(kSize, "short", "endian: little\nencoding: gzip\n\n") + deflated(data)},
      {"a.mha",
       "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n"
       "ElementDataFile = LOCAL\n" +
           data},
      {"a.vtk",
       "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n"
       "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 60\nSCALARS s short\nLOOKUP_TABLE default\n" +
           data},
      {"a.nii", nifti.bytes()},
      {"a.nii.gz", deflated(nifti.bytes())},
  };
  for (const auto& [name, content] : files) {
    SCOPED_TRACE(name);
    write_file(folder / name, content);
    EXPECT_EQ(error_of(folder / name).status, Status::ok) << error_of(folder / name).message;
    // The last eight bytes of a gzip member, after the last voxel, contain its checksum.
    const size_t end = content.size() - (name.find("gz") != name.npos || name[0] == 'b' ? 10 : 1);
    for (size_t size = 0; size <= end; size += size < 400 ? 7 : 1) {
      write_file(folder / name, content.substr(0, size));
      const Error error = error_of(folder / name);
      EXPECT_NE(error.status, Status::ok) << size;
      EXPECT_EQ(error.message.find('\n'), std::string::npos) << error.message;
    }
  }
}

TEST(ImportErrors, TwoAndFourDimensionsColoursAndUnknownTypes) {
  const TempFolder folder;
  write_file(folder / "flat.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 2 2\nencoding: raw\n\nabcd");
  expect_error(folder / "flat.nrrd", Status::no_cells, "found an image with 2");
  write_file(folder / "one.nrrd", nrrd_header({2, 2, 1}, "uint8", "encoding: raw\n\nabcd"));
  expect_error(folder / "one.nrrd", Status::no_cells, "2 × 2 × 1");
  write_file(folder / "rgb.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 2 2 2\n"
             "kinds: RGB-color domain domain domain\nencoding: raw\n\n" +
                 std::string(24, 'x'));
  expect_error(folder / "rgb.nrrd", Status::unsupported_type, "found 3 channels: choose one with");
  write_file(folder / "block.nrrd", nrrd_header(kSize, "block", "encoding: raw\n\nabcd"));
  expect_error(folder / "block.nrrd", Status::unsupported_type, "found block");
  write_file(folder / "rgb.mha",
             "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementNumberOfChannels = 3\n"
             "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                 std::string(24, 'x'));
  expect_error(folder / "rgb.mha", Status::unsupported_type, "found 3");
  test::NiftiFile nifti;
  nifti.sizes = {2, 2, 2};
  nifti.data_type = 128;
  nifti.bits = 24;
  nifti.voxels = std::string(24, 'x');
  write_file(folder / "rgb.nii", nifti.bytes());
  expect_error(folder / "rgb.nii", Status::unsupported_type, "found 3");
  nifti.data_type = 4;
  nifti.sizes = {2, 2};
  write_file(folder / "flat.nii", nifti.bytes());
  expect_error(folder / "flat.nii", Status::no_cells, "found an image with 2");
}

TEST(ImportErrors, MissingDataFilesAreNamed) {
  const TempFolder folder;
  write_file(folder / "v.nhdr",
             nrrd_header(kSize, "uint8", "encoding: raw\ndata file: gone.raw\n"));
  expect_error(folder / "v.nhdr", Status::io_error, "gone.raw");
  write_file(folder / "v.mhd",
             "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_UCHAR\n"
             "ElementDataFile = gone.raw\n");
  expect_error(folder / "v.mhd", Status::io_error, "gone.raw");
}

TEST(ImportErrors, OptionsThatDoNotFitTheFile) {
  const TempFolder folder;
  write_file(folder / "v.nrrd", nrrd_header(kSize, "uint8", "encoding: raw\n\n") +
                                    bytes_of(pattern_voxels<uint8_t>(kSize)));
  ImportOptions options;
  options.type = VoxelType::u16;
  expect_error(folder / "v.nrrd", Status::invalid_argument, "has a header", options);
  options = {};
  options.time_step = 1;
  expect_error(folder / "v.nrrd", Status::invalid_argument, "from 0 to 0", options);
}

TEST(ImportErrors, FlippedBytesOfHeadersNeverCrash) {
  const TempFolder folder;
  test::NiftiFile nifti;
  nifti.sizes = {5, 4, 3};
  nifti.voxels = bytes_of(pattern_voxels<int16_t>(kSize));
  const std::pair<std::string, std::string> files[] = {
      {"a.nrrd", nrrd_header(kSize, "short", "endian: little\nencoding: raw\n\n") + nifti.voxels},
      {"a.mha",
       "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n"
       "ElementDataFile = LOCAL\n" +
           nifti.voxels},
      {"a.nii", nifti.bytes()},
  };
  for (const auto& [name, content] : files) {
    for (size_t at = 0; at < std::min<size_t>(content.size(), 600); at += 5) {
      for (const char flip : {'\x01', '\x80'}) {
        std::string changed = content;
        changed[at] = static_cast<char>(changed[at] ^ flip);
        write_file(folder / name, changed);
        const Error error = error_of(folder / name);
        EXPECT_EQ(error.message.find('\n'), std::string::npos) << error.message;
      }
    }
  }
}

}  // namespace
}  // namespace isosplat::import
