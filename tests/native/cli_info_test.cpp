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

}  // namespace
}  // namespace isosplat
