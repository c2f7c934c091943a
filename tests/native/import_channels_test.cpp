// Several numbers for each voxel: --channel chooses one.
#include <cstring>

#include "tests/native/import_checks.h"
#include "tests/native/volume_files.h"

namespace isosplat::import {
namespace {

using test::bytes_of;
using test::error_of;
using test::expect_error;
using test::offered_choices;
using test::open;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};
constexpr size_t kVoxels = 5 * 4 * 3;

ImportOptions channel(int64_t number) {
  ImportOptions options;
  options.channel = number;
  return options;
}

template <class T>
std::vector<T> values_of(size_t of_channel) {
  return pattern_voxels<T>(kSize, 1, 5.0 * static_cast<double>(of_channel));
}

/// The numbers of all channels, voxel by voxel.
template <class T>
std::string alternating(size_t channels) {
  std::vector<T> values(channels * kVoxels);
  for (size_t c = 0; c < channels; ++c) {
    const auto one = values_of<T>(c);
    for (size_t i = 0; i < kVoxels; ++i) values[i * channels + c] = one[i];
  }
  return bytes_of(values);
}

template <class T>
std::string one_after_another(size_t channels) {
  std::string bytes;
  for (size_t c = 0; c < channels; ++c) bytes += bytes_of(values_of<T>(c));
  return bytes;
}

/// Each channel can be read, and one must be chosen.
template <class T>
void expect_channels(const std::filesystem::path& path, size_t channels,
                     const std::vector<std::string>& names = {}) {
  SCOPED_TRACE(path.string());
  expect_error(path, fmt::format("expected one number per voxel, found {} channels: choose one "
                                 "with --channel 0 to --channel {}",
                                 channels, channels - 1));
  expect_error(path, fmt::format("found {}", channels), channel(static_cast<int64_t>(channels)));
  const auto offered = offered_choices(path);
  ASSERT_EQ(offered.size(), channels);
  for (size_t c = 0; c < channels; ++c) {
    EXPECT_EQ(offered[c].channel, static_cast<int64_t>(c));
    EXPECT_EQ(offered[c].name, c < names.size() ? names[c] : "");
    EXPECT_EQ(offered[c].colour.has_value(), c < std::min<size_t>(names.size(), 3));
    const auto volume = open(path, channel(static_cast<int64_t>(c)));
    const auto values = values_of<T>(c);
    EXPECT_EQ(read_all(*volume.source), std::vector<double>(values.begin(), values.end()));
  }
}

TEST(ImportChannels, OfNrrdAlongAnyAxis) {
  const TempFolder folder;
  const auto write = [&](const std::string& name, const std::string& axes,
                         const std::string& data) {
    write_file(folder / name, "NRRD0004\ntype: short\ndimension: 4\n" + axes +
                                  "endian: little\nencoding: raw\n\n" + data);
    return folder / name;
  };
  expect_channels<int16_t>(write("a.nrrd", "sizes: 3 5 4 3\nkinds: vector domain domain domain\n",
                                 alternating<int16_t>(3)),
                           3);
  expect_channels<int16_t>(
      write("b.nrrd", "sizes: 3 5 4 3\nkinds: RGB-color domain domain domain\n",
            alternating<int16_t>(3)),
      3, {"red", "green", "blue"});
  expect_channels<int16_t>(write("c.nrrd", "sizes: 5 4 3 2\nkinds: domain domain domain complex\n",
                                 one_after_another<int16_t>(2)),
                           2);
}

TEST(ImportChannels, OfMetaImage) {
  const TempFolder folder;
  const std::string header =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 5 4 3\n"
      "ElementNumberOfChannels = 3\nElementType = MET_SHORT\nElementDataFile = ";
  write_file(folder / "v.mha", header + "LOCAL\n" + alternating<int16_t>(3));
  expect_channels<int16_t>(folder / "v.mha", 3);
  // Slices in separate files have one number for each voxel.
  write_file(folder / "v.mhd", header + "LIST\na.raw\nb.raw\nc.raw\n");
  expect_error(folder / "v.mhd", "found 3 (colours or vectors)", channel(0));
  for (const char* count : {"0", "-1", "x", "99999999999"}) {
    std::string wrong = header + "LOCAL\n";
    wrong.replace(wrong.find("Channels = 3"), 12, std::string("Channels = ") + count);
    write_file(folder / "v.mha", wrong);
    expect_error(folder / "v.mha", "ElementNumberOfChannels from 1 to");
  }
}

TEST(ImportChannels, OfNiftiInTheFifthAxisOrAsColours) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {5, 4, 3, 1, 3};
  file.voxels = one_after_another<int16_t>(3);
  write_file(folder / "vectors.nii", file.bytes());
  expect_channels<int16_t>(folder / "vectors.nii", 3);
  file.sizes = {5, 4, 3};
  file.data_type = 128;
  file.bits = 24;
  file.voxels = alternating<uint8_t>(3);
  write_file(folder / "rgb.nii", file.bytes());
  expect_channels<uint8_t>(folder / "rgb.nii", 3, {"red", "green", "blue"});
  file.data_type = 2304;
  file.bits = 32;
  file.voxels = alternating<uint8_t>(4);
  write_file(folder / "rgba.nii", file.bytes());
  expect_channels<uint8_t>(folder / "rgba.nii", 4, {"red", "green", "blue", "alpha"});
  // Several of both kinds, and flat images, are no volumes.
  for (const std::vector<int16_t>& sizes :
       {std::vector<int16_t>{5, 4}, {5, 4, 3, 2}, {5, 4, 3, 1, 2}, {5, 4, 3, 1, 1, 2}}) {
    file.sizes = sizes;
    write_file(folder / "wrong.nii", file.bytes());
    EXPECT_NE(error_of(folder / "wrong.nii", channel(0)), "") << sizes.size();
  }
  file.data_type = 4;
  file.bits = 16;
  for (const std::vector<int16_t>& sizes :
       {std::vector<int16_t>{5, 4, 3, 2, 2}, {5, 4, 3, 1, 2, 2}}) {
    file.sizes = sizes;
    write_file(folder / "wrong.nii", file.bytes());
    EXPECT_NE(error_of(folder / "wrong.nii", channel(0)), "") << sizes.size();
  }
}

TEST(ImportChannels, OfAScalarVolumeIsTheOnlyOne) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {5, 4, 3};
  file.voxels = one_after_another<int16_t>(1);
  write_file(folder / "v.nii", file.bytes());
  EXPECT_EQ(error_of(folder / "v.nii", channel(0)), "");
  expect_error(folder / "v.nii", "expected a --channel from 0 to 0, found 1", channel(1));
}

TEST(ImportChannels, OfVtkAreArraysAndComponents) {
  const TempFolder folder;
  const auto big_endian = [](std::string bytes) {
    for (size_t i = 0; i + 1 < bytes.size(); i += 2) std::swap(bytes[i], bytes[i + 1]);
    return bytes;
  };
  const auto text_of = [](const std::string& bytes) {
    std::vector<int16_t> numbers(bytes.size() / 2);
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    std::string text;
    for (const int16_t number : numbers) text += std::to_string(number) + " ";
    return text;
  };
  for (const bool is_binary : {true, false}) {
    const auto array = [&](const std::string& bytes) {
      return (is_binary ? big_endian(bytes) : text_of(bytes)) + "\n";
    };
    const std::string head = fmt::format(
        "# vtk DataFile Version 3.0\nx\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n"
        "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 60\n",
        is_binary ? "BINARY" : "ASCII");
    const std::string vectors = "VECTORS flow short\n" + array(alternating<int16_t>(3));
    const std::string scalars =
        "SCALARS heat short 1\nLOOKUP_TABLE default\n" + array(bytes_of(values_of<int16_t>(7)));
    const auto path = folder / "v.vtk";
    write_file(path, head + vectors);
    expect_error(path, "found 3 channels: choose one with --channel 0 to --channel 2");
    const auto expect_channel = [&](int64_t number, size_t pattern) {
      const auto values = values_of<int16_t>(pattern);
      EXPECT_EQ(read_all(*open(path, channel(number)).source),
                std::vector<double>(values.begin(), values.end()))
          << number;
    };
    for (int c = 0; c < 3; ++c) expect_channel(c, static_cast<size_t>(c));
    auto offered = offered_choices(path);
    ASSERT_EQ(offered.size(), 3u);
    EXPECT_EQ(offered[2].name, "flow, component 2");
    write_file(path, head + vectors + scalars);
    // Without a choice, the first scalars are read.
    std::vector<VolumeChoice> choices;
    ImportOptions options;
    options.choices = &choices;
    auto volume = open(path, options);
    const auto heat = values_of<int16_t>(7);
    EXPECT_EQ(read_all(*volume.source), std::vector<double>(heat.begin(), heat.end()));
    test::expect_note(volume, "4 arrays or components: 'heat' of its points is read; --channel 0");
    ASSERT_EQ(choices.size(), 4u);
    EXPECT_EQ(choices[3].name, "heat");
    expect_channel(1, 1);
    expect_channel(3, 7);
    expect_error(path,
                 "--channel from 0 to 3, found 4: choose another (0: flow, component 0; 1: flow, "
                 "component 1; 2: flow, component 2; 3: heat)",
                 channel(4));
    // The values of cells count only if points have none.
    write_file(path, head + scalars + "CELL_DATA 24\nSCALARS x short 1\nLOOKUP_TABLE default\n" +
                         array(std::string(48, 'x')));
    expect_channel(0, 7);
    expect_error(path, "--channel from 0 to 0, found 1", channel(1));
  }
}

TEST(ImportChannels, OfVtkAreNotOfferedIfTheScalarsAreNotAmongThem) {
  const TempFolder folder;
  const auto path = folder / "v.vtk";
  std::string vectors, scalars;
  for (int i = 0; i < 27; ++i) vectors += "1 2 3 ";
  for (int i = 0; i < 8; ++i) scalars += std::to_string(i) + " ";
  const std::string head =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\n"
      "SPACING 1 1 1\nORIGIN 0 0 0\n";
  write_file(path, head + "POINT_DATA 27\nVECTORS flow short\n" + vectors +
                       "\nCELL_DATA 8\nSCALARS heat short 1\nLOOKUP_TABLE default\n" + scalars);
  std::vector<VolumeChoice> choices;
  ImportOptions options;
  options.choices = &choices;
  EXPECT_EQ(read_all(*open(path, options).source), (std::vector<double>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_TRUE(choices.empty());
}

TEST(ImportChannels, OfVtkArraysWithoutValuesAreNotCounted) {
  const TempFolder folder;
  const auto path = folder / "v.vtk";
  std::string file =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 1 2 2\n"
      "SPACING 1 1 1\nORIGIN 0 0 0\nCELL_DATA 0\nFIELD f 100\n";
  for (int i = 0; i < 100; ++i) file += fmt::format("a{} 1000 0 char\n", i);
  write_file(path, file);
  EXPECT_NE(error_of(path), "");
  EXPECT_TRUE(offered_choices(path).empty());
}

}  // namespace
}  // namespace isosplat::import
