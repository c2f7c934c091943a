#include <gtest/gtest.h>

#include "tests/conformance/compare.h"
#include "tests/native/test_files.h"

// Reads files that VTK's own writers have written: every encoding, compressor and byte order.
namespace isosplat::conformance {
namespace {

TEST(VtkWriters, FilesAreReadAsWritten) {
  if (!std::filesystem::exists("/usr/bin/python3")) GTEST_SKIP() << "/usr/bin/python3 is missing";
  const test::TempFolder folder, output;
  const std::string command = "/usr/bin/python3 '" ISOSPLAT_SOURCE_DIR
                              "/tests/conformance/vtk_writers.py' '" +
                              folder.path().string() + "' > '" + (output / "out").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  if (test::read_file(output / "out").starts_with("absent")) {
    GTEST_SKIP() << "python3-vtk9 is not installed";
  }
  Truth truth;
  truth.sizes = {11, 10, 7};
  for (int i = 0; i < 770; ++i) truth.values.push_back(i * 0.25);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    const std::string name = entry.path().filename().string();
    // The files of pieces are parts of the volume.
    if (name.starts_with("files_") || name.starts_with("even_")) continue;
    if (name.find('.') == name.npos) continue;
    SCOPED_TRACE(name);
    if (name.ends_with("tr")) {
      truth.steps = {Vec3d{0.5, 0, 0}, Vec3d{0, 0.75, 0}, Vec3d{0, 0, 2}};
      truth.origin = {5, 5, 5};
    } else {  // x along y, and y along -x; the extent begins at 2, -1, 3
      truth.steps = {Vec3d{0, 0.5, 0}, Vec3d{-0.75, 0, 0}, Vec3d{0, 0, 2}};
      truth.origin = {10.75, 21, 36};
    }
    auto volume = import::open_volume(entry.path(), {});
    ASSERT_TRUE(volume) << volume.error().message;
    const auto values = read_values(*volume->source);
    ASSERT_TRUE(values) << values.error().message;
    EXPECT_EQ(difference(volume->source->header().grid, *values, truth), "");
    ++files;
  }
  EXPECT_EQ(files, 3 * 4 * 2 * 2 + 1 + 3);
}

}  // namespace
}  // namespace isosplat::conformance
