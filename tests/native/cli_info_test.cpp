#include <nlohmann/json.hpp>

#include "tests/native/cli_program.h"
#include "tests/native/volume_files.h"

// What `isosplat info` prints about a volume, and about the store that is built of it.
namespace isosplat {
namespace {

using test::run;
using test::TempFolder;
using test::write_file;

TEST(CliInfo, NamesTheFrameOfReferenceOfAVolumeAndOfItsStore) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {5, 4, 3};
  file.affine_code = 4;
  file.voxels = test::bytes_of(test::pattern_voxels<int16_t>({5, 4, 3}));
  const std::string volume = folder / "a.nii", store = folder / "a.isosplat";
  write_file(volume, file.bytes());
  ASSERT_EQ(run({"build", volume, "-q", "--no-thumbnail"}).exit_code, 0);
  for (const std::string& path : {volume, store}) {
    EXPECT_NE(run({"info", path}).out.find("frame         mni152\n"), std::string::npos) << path;
  }
  const auto of_volume = nlohmann::json::parse(run({"info", volume, "--json"}).out);
  EXPECT_EQ(of_volume["frameOfReference"], "mni152");
  const auto of_store = nlohmann::json::parse(run({"info", store, "--json"}).out);
  EXPECT_EQ(of_store["metadata"]["frame_of_reference"], "mni152");
  file.affine_code = 2;
  write_file(volume, file.bytes());
  EXPECT_EQ(run({"info", volume}).out.find("frame  "), std::string::npos);
}

// The store of a label has a header of its own.
TEST(CliInfo, NamesTheFrameOfReferenceOfLabels) {
  const TempFolder folder;
  test::NiftiFile file;
  file.sizes = {8, 8, 8};
  file.affine_code = 4;
  std::vector<int16_t> voxels(512);
  for (size_t i = 0; i < voxels.size(); ++i) {
    const size_t x = i % 8, y = i / 8 % 8, z = i / 64;
    const bool is_inside = x > 1 && x < 6 && y > 1 && y < 6 && z > 1 && z < 6;
    voxels[i] = static_cast<int16_t>(is_inside ? (x < 4 ? 1 : 2) : 0);
  }
  file.voxels = test::bytes_of(voxels);
  write_file(folder / "seg.nii", file.bytes());
  const std::string scene = folder / "scene/";
  const test::Ended built = run({"build", folder / "seg.nii", "--labels", "-o", scene, "-q"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  for (const char* label : {"label_1", "label_2"}) {
    const std::string store = scene + "stores/" + label + ".isosplat";
    EXPECT_NE(run({"info", store}).out.find("frame         mni152\n"), std::string::npos) << label;
  }
}

}  // namespace
}  // namespace isosplat
