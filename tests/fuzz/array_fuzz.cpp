// MRC, MGH, netCDF, NumPy, HDF5, VTK XML, cube, VASP, XSF and OpenDX files: their headers, and
// their voxels if they are few.
//
// If the first byte of the input is 128 or more, the rest is a file. Otherwise the byte is the
// number of a valid file, and the rest are edits of it.
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "shared/import/open_volume.h"
#include "tests/conformance/netcdf_writer.h"
#include "tests/fuzz/edits.h"

namespace isosplat::import {
namespace {

/// Five columns, four rows and three sections.
std::string mrc(int32_t mode, size_t voxel_bytes) {
  std::string file(1024 + 60 * voxel_bytes, '\7');
  std::fill_n(file.begin(), 1024, '\0');
  const auto set = [&](size_t word, auto value) { std::memcpy(&file[4 * (word - 1)], &value, 4); };
  const int32_t sizes[] = {5, 4, 3};
  for (size_t i = 0; i < 3; ++i) {
    set(1 + i, sizes[i]);
    set(8 + i, sizes[i]);
    set(11 + i, static_cast<float>(2 * sizes[i]));
    set(14 + i, i == 0 ? 80.0f : 90.0f);
    set(17 + i, static_cast<int32_t>(3 - i));
  }
  set(4, mode);
  file.replace(208, 6, "MAP DD");
  return file;
}

/// The same of FreeSurfer, with 16-bit voxels.
std::string mgh() {
  std::string file(284 + 120, '\0');
  for (const size_t byte : {3, 19}) file[byte] = 1;
  file[7] = 5;
  file[11] = 4;
  file[15] = 3;
  file[23] = 4;
  file[29] = 1;
  for (size_t i = 0; i < 3; ++i) {  // 1.0: the spacing, and the directions
    file.replace(30 + 4 * i, 2, "\x3f\x80");
    file.replace(42 + 16 * i, 2, "\x3f\x80");
  }
  return file;
}

std::string npy(const std::string& dictionary, size_t voxel_bytes) {
  std::string file = "\x93NUMPY";
  file += {'\1', '\0', static_cast<char>(dictionary.size()), '\0'};
  return file + dictionary + std::string(60 * voxel_bytes, '\7');
}

/// An image of VTK's XML format: five columns, four rows and three slices. `content`: of its
/// DataArray; `after`: after the grid.
std::string vti(const std::string& attributes, const std::string& array, const std::string& content,
                const std::string& after = "") {
  return "<VTKFile type=\"ImageData\" version=\"1.0\" header_type=\"UInt32\" " + attributes +
         "><ImageData WholeExtent=\"0 4 0 3 0 2\" Origin=\"0 0 0\" Spacing=\"1 1 1\">"
         "<Piece Extent=\"0 4 0 3 0 2\"><PointData><DataArray type=\"UInt8\" Name=\"a\" format=\"" +
         array + "\">" + content + "</DataArray></PointData></Piece></ImageData>" + after +
         "</VTKFile>";
}

/// Numbers of four bytes.
std::string words(std::initializer_list<uint8_t> numbers) {
  std::string out;
  for (const uint8_t number : numbers) out += {static_cast<char>(number), '\0', '\0', '\0'};
  return out;
}

std::string vti_of_text() {
  std::string text;
  for (int i = 0; i < 60; ++i) text += std::to_string(i) + " ";
  return vti("", "ascii", text);
}

/// Two blocks of LZ4 with literal bytes.
std::string vti_of_blocks() {
  const std::string block = std::string("\xf0\x0f", 2) + std::string(30, '\7');
  return vti("compressor=\"vtkLZ4DataCompressor\"", "appended\" offset=\"0", "",
             "<AppendedData encoding=\"raw\">_" + words({2, 30, 0, 32, 32}) + block + block +
                 "</AppendedData>");
}

/// Sixty values.
std::string values_as_text() {
  std::string text;
  for (int i = 0; i < 60; ++i) text += std::to_string(i) + ".5 ";
  return text + "\n";
}

std::string cube() {
  return "a\nb\n-1 0 0 0\n3 0 0 1\n4 0 1 0\n5 1 0 0\n6 0 0 0 0\n1 7\n" + values_as_text();
}

std::string vasp() {
  return "a\n1\n1 0 0\n0 1 0\n0 0 1\nSi\n1\nDirect\n0 0 0\n\n5 4 3\n" + values_as_text() +
         "augmentation occupancies 1 1\n0.5\n5 4 3\n" + values_as_text();
}

std::string xsf() {
  return "CRYSTAL\nBEGIN_BLOCK_DATAGRID_3D\na\nBEGIN_DATAGRID_3D_b\n5 4 3\n0 0 0\n1 0 0\n0 1 0\n"
         "0 0 1\n" +
         values_as_text() + "END_DATAGRID_3D\nEND_BLOCK_DATAGRID_3D\n";
}

std::string opendx() {
  return "object 1 class gridpositions counts 3 4 5\norigin 0 0 0\ndelta 1 0 0\ndelta 0 1 0\n"
         "delta 0 0 1\nobject 3 class array type double rank 0 items 60 data follows\n" +
         values_as_text() + "object \"a\" class field\n";
}

/// Records of slices, with positions and a fill value.
std::string netcdf(int version) {
  using conformance::Number;
  conformance::NetcdfWriter file(version);
  file.axes = {{"z", 3, true}, {"y", 4}, {"x", 5}};
  file.records = 3;
  file.arrays = {
      {"z", {0}, Number::f64, {0, 2, 4}, {{"units", "mm"}, {"positive", "down"}}},
      {"a",
       {0, 1, 2},
       Number::i16,
       std::vector<double>(60, 7),
       {{"_FillValue", "", Number::i16, {8}}, {"scale_factor", "", Number::f32, {0.5}}}}};
  return file.bytes();
}

/// A file that the HDF5 library has written.
std::string hdf5(const std::string& name) {
  std::ifstream file(std::string(ISOSPLAT_SOURCE_DIR) + "/tests/native/hdf5/" + name + ".h5",
                     std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> make_files() {
  return {hdf5("filtered"),
          hdf5("ilastik"),
          hdf5("latest_fixed"),
          hdf5("latest_pages"),
          hdf5("nexus"),
          hdf5("sparse"),
          mrc(0, 1),
          mrc(1, 2),
          mrc(2, 4),
          mrc(12, 2),
          npy("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), }", 4),
          npy("{'descr': '>f2', 'fortran_order': True, 'shape': (1, 3, 4, 5), }\n", 2),
          npy("{\"shape\": (3L, 4L, 5L), 'fortran_order': False, 'descr': '|u1'}", 1),
          mrc(101, 1),
          hdf5("growing"),
          hdf5("growing_all"),
          hdf5("heaps"),
          hdf5("lz4"),
          hdf5("lzf"),
          hdf5("conventions/bdv"),
          hdf5("conventions/scales"),
          mgh(),
          netcdf(1),
          netcdf(5),
          cube(),
          vasp(),
          xsf(),
          opendx(),
          vti_of_text(),
          vti("", "binary", "PAAAA" + std::string(81, 'A') + "=="),
          vti_of_blocks(),
          vti("", "appended\" offset=\"0", "",
              "<AppendedData encoding=\"raw\">_" + words({60}) + std::string(60, '\7') +
                  "</AppendedData>")};
}

void read_file(const std::filesystem::path& path) {
  ImportOptions options;
  options.allowed.add(Allowance::truncated);
  auto volume = open_volume(path, options);
  if (!volume) return;
  const VolumeHeader& header = volume->source->header();
  const Index3 n = header.grid.voxels;
  const uint64_t slice = static_cast<uint64_t>(n.x) * static_cast<uint64_t>(n.y);
  if (slice > 1 << 16) return;
  std::vector<std::byte> out(static_cast<size_t>(slice) * voxel_bytes(header.type));
  for (const int32_t z : {0, n.z - 1}) static_cast<void>(volume->source->read_slices(z, 1, out));
}

}  // namespace
}  // namespace isosplat::import

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isosplat;
  using namespace isosplat::import;
  static const std::vector<std::string> files = make_files();
  static const int memory = memfd_create("array", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(memory);
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
