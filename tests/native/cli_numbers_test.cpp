#include <nlohmann/json.hpp>

#include "tests/native/cli_program.h"

// Numbers on the command line, and messages about them.
namespace isosplat {
namespace {

using test::Call;
using test::Ended;
using test::run;
using test::TempFolder;
using test::write_ball;
using test::write_file;

TEST(CliNumbers, OnlyNumbersAreAccepted) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 12), store = folder / "ball.isosplat";
  ASSERT_EQ(run({"build", volume, "-q", "--no-thumbnail"}).exit_code, 0);
  struct Option {
    std::vector<std::string> call;
    std::vector<std::string> refused;
  };
  const std::vector<std::string> render{"render", store, "-i", "60.5", "-o", folder / "x.png"};
  const std::vector<std::string> extract{"extract", store, "-o", folder / "x.ply"};
  const auto with = [](std::vector<std::string> call, const std::string& option) {
    call.push_back(option);
    return call;
  };
  // Two of these for each option, in turn: one function reads the numbers of all options.
  const std::vector<std::string> never{"nan", "", "0x10", "5x", "1e999"};
  size_t next = 0;
  const std::vector<Option> options = {
      {with(extract, "--isovalue"), {}},
      {with({"extract", store, "-i", "60.5", "-o", folder / "x.ply"}, "--level"),
       {"-1", "1.5", "33", "99999999999999999999"}},
      {with({"extract", store, "-i", "60.5", "-o", folder / "x.ply"}, "--threads"),
       {"-1", "10000", "2.5"}},
      {with({"verify", store}, "--threads"), {"-1", "10000"}},
      {with({"render", store, "-o", folder / "x.png"}, "--isovalue"), {"60.5,nan"}},
      {with(render, "--size"),
       {"100xabc", "1e3x1e3", "100x", "x100", "0x0", "-5x5", "100000x100000", "10.5x10"}},
      {with(render, "--level"), {"-1", "1.5"}},
      {with(render, "--turntable"), {"-3", "0", "1.5"}},
      {with(render, "--samples"), {"-1", "1e3"}},
      {with(render, "--azimuth"), {}},
      {with(render, "--zoom"), {"0", "-1"}},
      {with(render, "--distance"), {"-1"}},
      {with(render, "--field-of-view"), {"0", "180"}},
      {with(render, "--opacity"), {"-0.5", "2"}},
      {with(render, "--eye-dome"), {"2"}},
      {with(render, "--light"), {"40", "0,200"}},
      {with(render, "--light-strength"), {"3", "1,1,1,1"}},
      {with(render, "--occlusion"), {"2", "-1"}},
      {with(render, "--shadow"), {"1,2"}},
      {with(render, "--target"), {"1,2", "1,2,nan", "1,2,3,4"}},
      {with(render, "--clip-box"), {"0,0,0,1,1", "0,0,0,1,1,nan"}},
      {with({"build", volume}, "--threads"), {"-1", "10000", "1.5"}},
      {with({"build", volume}, "--memory"), {"-1", "1e9", "5X", "1..5G", "0", ".", "G"}},
      {with({"build", volume}, "--spacing"), {"1,1", "1,1,0", "1,1,-2", "1,1,nan", "1,,1"}},
      {with({"build", volume}, "--time-step"), {"-1", "0.5"}},
      {with({"build", volume}, "--max-error"), {"-1", "0"}},
      {with({"build", volume}, "--skip-bytes"), {"-1", "1.5"}},
      {with({"build", volume, "--type", "u8"}, "--dims"),
       {"12x12", "12x12x0", "1e1x12x12", "12x12x-1", "12x12x12x12"}},
      {with({"serve", store}, "--port"), {"-1", "65536", "80.5"}},
      {with({"view", store}, "--port"), {"-1", "65536"}},
      {with({"serve", store}, "--threads"), {"-1", "100000"}},
  };
  for (const Option& option : options) {
    std::vector<std::string> refused = option.refused;
    for (int i = 0; i < 2; ++i) refused.push_back(never[next++ % never.size()]);
    for (const std::string& text : refused) {
      std::vector<std::string> call = option.call;
      // Option and text are one argument, so that the text is not parsed as another option.
      call.back() += "=" + text;
      SCOPED_TRACE(call.back());
      const Ended ended = run(call);
      EXPECT_EQ(ended.exit_code, 2) << ended.err;
      EXPECT_TRUE(ended.err.starts_with("isosplat: ")) << ended.err;
      EXPECT_NE(ended.err.find(option.call.back()), std::string::npos) << ended.err;
      EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
    }
  }
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.isosplat", "ball.nrrd"}));
  const Ended infinite = run({"extract", store, "-i", "nan", "-o", folder / "x.ply"});
  EXPECT_NE(infinite.err.find("expected a number such as 60.5, found 'nan'"), std::string::npos)
      << infinite.err;
}

TEST(CliNumbers, NumbersAreAccepted) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 12), store = folder / "ball.isosplat";
  EXPECT_EQ(run({"build", volume, "--spacing", "1,1e0,+2.5", "--memory", "1.5g", "--threads", "0"})
                .exit_code,
            0);
  for (const std::string isovalue : {"-300", "+60.5", "6e1", ".5"}) {
    EXPECT_EQ(run({"extract", store, "-i", isovalue, "-o", folder / "x.ply"}).exit_code, 0)
        << isovalue;
  }
}

TEST(CliNumbers, AMemoryLimitAboveTheMachinesMemoryIsNoted) {
  const TempFolder folder;
  const Ended ended = run({"build", write_ball(folder, 12), "--memory", "8T"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("note: --memory 8T exceeds the memory of this machine"),
            std::string::npos)
      << ended.err;
}

TEST(CliNumbers, QuietPrintsErrorsOnly) {
  const TempFolder folder;
  std::string voxels(24 * 24 * 24, 'a');
  for (size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<char>(i % 90);
  write_file(folder / "v_24x24x24_uint8.raw", voxels);  // read with a note
  const std::string volume = folder / "v_24x24x24_uint8.raw";
  const Ended loud = run({"build", volume});
  EXPECT_NE(loud.err.find("note: "), std::string::npos);
  EXPECT_NE(loud.out, "");
  const Ended quiet = run({"build", volume, "-q", "--memory", "8T"});
  EXPECT_EQ(quiet.exit_code, 0) << quiet.err;
  EXPECT_EQ(quiet.out, "");
  EXPECT_EQ(quiet.err, "");
  const Ended failed = run({"build", volume, "-q", "--memory", "1M"});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_EQ(std::count(failed.err.begin(), failed.err.end(), '\n'), 1) << failed.err;
}

TEST(CliNumbers, AnIsovalueWithoutIsosurfaceIsReported) {
  const TempFolder folder;
  // A step from 10 to 200 where all cells have a missing voxel.
  std::vector<float> values;
  for (int i = 0; i < 12 * 12 * 12; ++i) {
    const int x = i % 12;
    values.push_back(x < 6 ? 10 : x == 6 ? std::nanf("") : 200);
  }
  write_file(folder / "gap.raw", test::bytes_of(values));
  ASSERT_EQ(
      run({"build", folder / "gap.raw", "--dims", "12x12x12", "--type", "f32", "-q"}).exit_code, 0);
  const auto extract = [&](const std::string& isovalue) {
    const Ended ended =
        run({"extract", folder / "gap.isosplat", "-i", isovalue, "-o", folder / "x.ply"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended.err;
  };
  EXPECT_NE(extract("500").find("no isosurface at 500: the volume's values are 10 to 200"),
            std::string::npos);
  EXPECT_NE(extract("-3").find("no isosurface at -3"), std::string::npos);
  EXPECT_EQ(extract("100").find("no isosurface"), std::string::npos);
  EXPECT_NE(extract("100").find("touch missing voxels"), std::string::npos);
}

TEST(CliNumbers, AnEmptyPictureIsExplained) {
  const TempFolder folder;
  ASSERT_EQ(run({"build", write_ball(folder, 20), "-q"}).exit_code, 0);
  const auto render = [&](const std::string& isovalue, const std::string& clip_box) {
    const Ended ended = run({"render", folder / "ball.isosplat", "-i", isovalue, "--size", "48",
                             "--clip-box", clip_box, "--aliased", "-o", folder / "x.png"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended.err;
  };
  EXPECT_EQ(render("100.5", "0,0,0,1,1,1"), "");
  EXPECT_TRUE(render("100.5", "0,0,0,0.01,0.01,0.01").starts_with("note: the picture is empty"));
  EXPECT_TRUE(render("300", "0,0,0,1,1,1").starts_with("note: no isosurface at 300"));
}

TEST(CliNumbers, AddressesOfObjectsAreNotShown) {
  const TempFolder folder;
  write_file(folder / "a.vtk",
             "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET STRUCTURED_POINTS\n");
  write_file(folder / "b.mhd", "NDims = 3\nDimSize = 4 4\nElementDataFile = LOCAL\n");
  write_file(folder / "c.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\n"
             "space directions: (0,0,0) (1,0) x\nencoding: hex\n\nzz");
  write_file(folder / "d.dcm", std::string(128, '\0') + "DICM and nothing more");
  std::string nifti(400, '\0');
  nifti[0] = 92, nifti[1] = 1, nifti[40] = 3, nifti[42] = 4, nifti[44] = 4, nifti[46] = 4;
  nifti[70] = 2, nifti.replace(344, 3, "n+1");
  write_file(folder / "e.nii", nifti);
  for (const std::string& name : folder.files()) {
    const Ended ended = run({"info", folder / name});
    EXPECT_EQ(ended.exit_code, 1) << name;
    EXPECT_EQ(ended.err.find("0x"), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("itk::"), std::string::npos) << ended.err;
  }
}

}  // namespace
}  // namespace isosplat
