#include "tests/native/import_checks.h"

// Headers that contradict their data or themselves, and assumptions that need a note. In all of
// these cases, an earlier version reported no error and no note.
namespace isosplat::import {
namespace {

using test::bytes_of;
using test::deflated;
using test::error_of;
using test::expect_error;
using test::expect_note;
using test::nrrd_header;
using test::open;
using test::pattern_voxels;
using test::read_all;
using test::TempFolder;
using test::write_file;

constexpr Index3 kSize{5, 4, 3};

std::string voxels() {
  return bytes_of(pattern_voxels<int16_t>(kSize));
}

std::vector<double> pattern_values() {
  return pattern_voxels<double>(kSize);
}

std::string nrrd(const std::string& lines) {
  return nrrd_header(kSize, "short", "encoding: raw\nendian: little\n" + lines);
}

std::string meta_image(const std::string& lines, const std::string& data_file = "LOCAL") {
  return "NDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\n" + lines +
         "ElementDataFile = " + data_file + "\n";
}

ImportOptions with_all_allowances() {
  ImportOptions options;
  for (const AllowanceFlag& flag : kAllowances) options.allowed.add(flag.allowance);
  return options;
}

// If the voxels are at the end of their file and the file is cut, it is unknown where they begin.
TEST(Contradictions, VoxelsAtTheEndOfACutFileAreAnErrorInAnyCase) {
  const TempFolder folder;
  const std::string n = nrrd("spacings: 1 1 1\nbyte skip: -1\n");
  const std::string m = meta_image("ElementSpacing = 1 1 1\nHeaderSize = -1\n");
  write_file(folder / "v.nrrd", n + "\n" + voxels());
  write_file(folder / "v.mha", m + voxels());
  EXPECT_EQ(read_all(*open(folder / "v.nrrd").source), pattern_values());
  EXPECT_EQ(read_all(*open(folder / "v.mha").source), pattern_values());
  for (const size_t cut : {1, 2, 30, 119}) {
    const std::string rest = voxels().substr(0, voxels().size() - cut);
    write_file(folder / "v.nrrd", n + "\n" + rest);
    write_file(folder / "v.mha", m + rest);
    write_file(folder / "v.nhdr", n + "data file: v.raw\n");
    write_file(folder / "v.raw", rest);
    for (const char* name : {"v.nrrd", "v.mha", "v.nhdr"}) {
      expect_error(folder / name, "at the end of the file");
      expect_error(folder / name, "at the end of the file", with_all_allowances());
    }
  }
}

TEST(Contradictions, ADataFileWhoseNameBeginsWithListIsAFile) {
  const TempFolder folder;
  write_file(folder / "list.raw", voxels());
  write_file(folder / "v.nhdr", nrrd("spacings: 1 1 1\ndata file: list.raw\n"));
  write_file(folder / "v.mhd", meta_image("ElementSpacing = 1 1 1\n", "list.raw"));
  EXPECT_EQ(read_all(*open(folder / "v.nhdr").source), pattern_values());
  EXPECT_EQ(read_all(*open(folder / "v.mhd").source), pattern_values());
}

TEST(Contradictions, NrrdAxesWithADirectionAreNotColoursOrTimes) {
  const TempFolder folder;
  const std::string space = "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n";
  for (const char* kind : {"3-color", "vector", "list", "time"}) {
    write_file(folder / "v.nrrd",
               nrrd(space + fmt::format("kinds: domain domain {}\n\n", kind)) + voxels());
    expect_error(folder / "v.nrrd", fmt::format("its kind is '{}'", kind));
  }
  write_file(folder / "v.nrrd", nrrd(space + "kinds: domain space domain\n\n") + voxels());
  EXPECT_EQ(error_of(folder / "v.nrrd"), "");
}

TEST(Contradictions, NrrdSpacingsAndUnitsFitTheSpaceDirections) {
  const TempFolder folder;
  const std::string space = "space: LPS\nspace directions: (1,0,0) (0,2,0) (0,0,3)\n";
  write_file(folder / "v.nrrd", nrrd(space + "spacings: 1 2 3\n\n") + voxels());
  EXPECT_EQ(error_of(folder / "v.nrrd"), "");
  write_file(folder / "v.nrrd", nrrd(space + "spacings: 1 2 4\n\n") + voxels());
  expect_error(folder / "v.nrrd", "axis 3 has the spacing 4");
  for (const char* units : {"um um um", "\"um\" \"um\"", "\"um\""}) {
    write_file(folder / "v.nrrd", nrrd(space + "space units: " + units + "\n\n") + voxels());
    expect_error(folder / "v.nrrd", "expected 3 units in quotes");
  }
}

TEST(Contradictions, NrrdFieldsWithoutEffectAreNoted) {
  const TempFolder folder;
  write_file(folder / "v.nrrd", nrrd("spacings: 1 1 1\nspace orgin: (1,2,3)\n\n") + voxels());
  expect_note(open(folder / "v.nrrd"), "field 'spaceorgin' is unknown");
  write_file(folder / "v.nrrd", nrrd("spacings: 1 1 1\nold min: -5\nold max: 7\n\n") + voxels());
  expect_note(open(folder / "v.nrrd"), "quantized from the range -5 to 7");
  write_file(folder / "v.nrrd", nrrd("space: RAS\nspacings: 1 1 1\n\n") + voxels());
  expect_note(open(folder / "v.nrrd"), "no space directions");
}

TEST(Contradictions, MetaImageFieldsThatOccurTwiceAreErrors) {
  const TempFolder folder;
  const auto write = [&](const std::string& lines) {
    write_file(folder / "v.mha", meta_image(lines) + voxels());
  };
  write("ElementSpacing = 1 1 1\nElementSpacing = 1 1 1\nComment = a\nComment = b\n");
  EXPECT_EQ(error_of(folder / "v.mha"), "");
  write("ElementSpacing = 1 1 1\nElementSpacing = 2 2 2\n");
  expect_error(folder / "v.mha", "occurs twice");
  write("Offset = 1 2 3\nPosition = 1.0 2 3\n");
  EXPECT_EQ(error_of(folder / "v.mha"), "");
  write("Offset = 1 2 3\nPosition = 10 20 30\n");
  expect_error(folder / "v.mha", "Position, which means the same");
}

TEST(Contradictions, AnOriginThatIsNotFiniteIsNoted) {
  const TempFolder folder;
  write_file(folder / "v.mha", meta_image("ElementSpacing = 1 1 1\nOffset = nan 2 3\n") + voxels());
  expect_note(open(folder / "v.mha"), "origin is not finite");
}

TEST(Contradictions, NiftiTransformsOfDifferentHandednessAreNoted) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {5, 4, 3};
  file.voxels = voxels();
  file.rows = {{{-1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  file.has_rotation = true;
  std::string bytes = file.bytes();
  bytes[254] = 2;  // sform: aligned; the codes differ, so that the transforms may differ as well
  write_file(folder / "v.nii", bytes);
  expect_note(open(folder / "v.nii"), "mirrors the volume");
}

TEST(Contradictions, NegativeNiftiSpacingsDoNotReverseTheQform) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {5, 4, 3};
  file.voxels = voxels();
  file.has_rotation = true;
  std::string bytes = file.bytes();
  bytes[254] = 0;  // no sform
  const float negative = -2;
  std::memcpy(&bytes[84], &negative, sizeof negative);  // along y
  write_file(folder / "v.nii", bytes);
  const auto volume = open(folder / "v.nii");
  expect_note(volume, "negative spacings");
  const VolumeGrid& grid = volume.source->header().grid;
  EXPECT_LT(length(grid.world({4, 3, 2}) - Vec3d{-4, -6, 2}), 1e-6);
  EXPECT_EQ(read_all(*volume.source), pattern_values());
}

std::string vtk(const std::string& type, bool text, const std::string& data,
                const std::string& lines = "SPACING 1 1 1\nORIGIN 0 0 0\n") {
  return fmt::format(
      "# vtk DataFile Version 3.0\nt\n{}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n{}"
      "POINT_DATA 60\nSCALARS s {}\nLOOKUP_TABLE default\n{}",
      text ? "ASCII" : "BINARY", lines, type, data);
}

TEST(Contradictions, VtkValuesBeyondTheDeclaredNumberAreErrorsUnlessAllowed) {
  const TempFolder folder;
  std::string text;
  for (const double value : pattern_values()) text += fmt::format("{} ", value);
  const std::string binary = bytes_of(test::byte_swapped(pattern_voxels<int16_t>(kSize)));
  const std::string complete[] = {vtk("short", true, text + "\n"),
                                  vtk("short", true, text + "\nGLOBAL_IDS x int\n1 2\n"),
                                  vtk("short", false, binary), vtk("short", false, binary + "\n\n"),
                                  vtk("short", false, binary + "\nMETADATA\nINFORMATION 0\n\n")};
  for (const std::string& file : complete) {
    write_file(folder / "v.vtk", file);
    EXPECT_EQ(read_all(*open(folder / "v.vtk").source), pattern_values()) << file;
  }
  const std::string surplus[] = {vtk("short", true, text + "7 8\n"),
                                 vtk("short", true, text + "\n7 8\n"),
                                 vtk("unsigned_char", false, binary)};
  for (const std::string& file : surplus) {
    write_file(folder / "v.vtk", file);
    expect_error(folder / "v.vtk", "--allow-surplus");
    EXPECT_EQ(error_of(folder / "v.vtk", with_all_allowances()), "");
  }
}

TEST(Contradictions, VtkFieldsThatOccurTwiceAreErrors) {
  const TempFolder folder;
  std::string text;
  for (int i = 0; i < 60; ++i) text += fmt::format("{} ", i);
  for (const char* lines : {"SPACING 1 1 1\nASPECT_RATIO 2 1 1\n", "ORIGIN 0 0 0\nORIGIN 0 0 1\n",
                            "SPACING 1 1 1\nDIMENSIONS 3 4 5\n"}) {
    write_file(folder / "v.vtk", vtk("short", true, text + "\n", lines));
    expect_error(folder / "v.vtk", "occurs twice");
  }
}

TEST(Contradictions, AVtkFileThatEndsInAnotherArrayIsNoted) {
  const TempFolder folder;
  const std::string binary = bytes_of(test::byte_swapped(pattern_voxels<int16_t>(kSize)));
  write_file(folder / "v.vtk", vtk("short", false, binary + "\nVECTORS flow float\nabc"));
  const auto volume = open(folder / "v.vtk");
  expect_note(volume, "ends within the array 'flow'");
  EXPECT_EQ(read_all(*volume.source), pattern_values());
}

TEST(Contradictions, AssumptionsAboutRawFilesAreNoted) {
  const TempFolder folder;
  write_file(folder / "v.raw", voxels());
  ImportOptions options;
  options.dims = {5, 4, 3};
  options.type = VoxelType::i16;
  const auto volume = open(folder / "v.raw", options);
  expect_note(volume, "little-endian");
  expect_note(volume, "no voxel spacing");
  options.big_endian = false;
  options.spacing = Vec3d{1, 1, 1};
  EXPECT_TRUE(open(folder / "v.raw", options).notes.empty());
}

}  // namespace
}  // namespace isosplat::import
