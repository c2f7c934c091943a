#include <chrono>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

#include "tests/native/cli_program.h"

// The program itself: exit codes, messages, and the files that it leaves behind.
namespace isosplat {
namespace {

using test::ball;
using test::Call;
using test::Ended;
using test::read_file;
using test::run;
using test::serve_and_stop;
using test::serve_until_logged;
using test::TempFolder;
using test::write_ball;
using test::write_file;

size_t lines(const std::string& text) {
  return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(Cli, HelpShowsExamplesForEveryCommand) {
  const Ended program = run({"--help"});
  EXPECT_EQ(program.exit_code, 0);
  for (const char* command :
       {"build", "info", "serve", "view", "extract", "verify", "demo", "publish", "sign-link"}) {
    EXPECT_NE(program.out.find(command), std::string::npos);
    const Ended help = run({command, "--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_NE(help.out.find(fmt::format("Examples:\n  isosplat {}", command)), std::string::npos)
        << help.out;
  }
  EXPECT_EQ(run({"--version"}).exit_code, 0);
}

TEST(Cli, BuildNotesAStoreAboveTheSizeLimit) {
  const TempFolder folder;
  std::mt19937 random(1);
  std::string noise;
  for (int i = 0; i < 40 * 40 * 40; ++i) noise.push_back(static_cast<char>(random() % 256));
  const std::string volume = folder / "noise.raw", store = folder / "noise.isosplat";
  write_file(volume, noise);
  const std::vector<std::string> build = {"build",  volume,     "-o",     store,
                                          "--dims", "40x40x40", "--type", "u8"};
  const Ended ended = run(build);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.out.find("exceeds the size limit of 64 kB"), std::string::npos) << ended.out;
  std::vector<std::string> larger = build;
  larger.insert(larger.end(), {"--fetch-weight", "9"});
  EXPECT_EQ(run(larger).out.find("size limit"), std::string::npos);
}

TEST(Cli, WrongCallsPrintOneLineAndExitWithTwo) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 8);
  const std::vector<std::vector<std::string>> calls = {
      {},
      {"frobnicate"},
      {"build"},
      {"build", volume, "--memory", "lots"},
      {"build", volume, "--fetch-weight", "-1"},
      {"build", volume, "--spacing", "1,2"},
      {"build", volume, "--dims", "8x8x8", "--type", "u8"},
      {"build", volume, "--time-step", "3"},
      {"build", volume, "-o", volume},
      {"extract", "x.isosplat"},
      {"serve", "--port", "70000", "x"},
      {"serve", "--threads", "5000", "x"},
      {"demo", folder.path(), "--only", "teapot"},
  };
  for (const auto& call : calls) {
    const Ended ended = run(call);
    EXPECT_EQ(ended.exit_code, 2) << (call.empty() ? "" : call[0]) << ended.err;
    EXPECT_EQ(lines(ended.err), 1u) << ended.err;
    EXPECT_TRUE(ended.err.starts_with("isosplat: ")) << ended.err;
    EXPECT_EQ(ended.out, "");
  }
  EXPECT_EQ(run({"frobnicate"}).err,
            "isosplat: expected a subcommand, found 'frobnicate'; see isosplat --help\n");
  EXPECT_EQ(folder.files(), std::vector<std::string>{"ball.nrrd"});
}

TEST(Cli, FailuresPrintOneLineAndExitWithOne) {
  const TempFolder folder;
  write_file(folder / "empty.nrrd", "");
  write_file(folder / "text.nrrd", "not a volume");
  write_file(folder / "short.nrrd",
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 99 99 99\nencoding: raw\n\nabc");
  write_file(folder / "broken.isosplat", "\x89ISOS\r\n\x1a and nothing more");
  const std::string not_there = folder / "not_there";
  const std::vector<std::vector<std::string>> calls = {
      {"build", folder / "empty.nrrd"},
      {"build", folder / "text.nrrd"},
      {"build", folder / "short.nrrd"},
      {"build", not_there},
      {"info", not_there},
      {"info", folder / "short.nrrd"},
      {"info", folder / "broken.isosplat"},
      {"verify", folder / "broken.isosplat"},
      {"verify", not_there},
      {"extract", folder / "broken.isosplat", "-i", "3"},
      {"serve", not_there},
      {"view", not_there},
      {"view", folder / "broken.isosplat"},
      {"build", folder / "broken.isosplat"},
      {"demo", folder / "text.nrrd" / "below"},
  };
  for (const auto& call : calls) {
    const Ended ended = run(call);
    EXPECT_EQ(ended.exit_code, 1) << call[0] << ended.err;
    EXPECT_EQ(lines(ended.err), 1u) << ended.err;
    EXPECT_TRUE(ended.err.starts_with("isosplat: ")) << ended.err;
  }
  EXPECT_EQ(folder.files(),
            (std::vector<std::string>{"broken.isosplat", "empty.nrrd", "short.nrrd", "text.nrrd"}));
}

TEST(Cli, BuildsInspectsVerifiesAndExtracts) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 40), store = folder / "ball.isosplat";
  const Ended built = run(Call{.arguments = {"build", volume, "--name", "A ball", "--units", "HU"},
                               .draws_thumbnails = true});
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.out.find("40 × 40 × 40 voxels"), std::string::npos) << built.out;
  EXPECT_NE(built.err.find("Building ball.isosplat: "), std::string::npos) << "plain progress";
  EXPECT_EQ(built.err.find('\r'), std::string::npos) << "no bar without a terminal";
  EXPECT_EQ(folder.files(),
            (std::vector<std::string>{"ball.isosplat", "ball.isosplat.webp", "ball.nrrd"}));

  const Ended verified = run({"verify", store});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_NE(verified.out.find("valid"), std::string::npos);

  const Ended info = run({"info", store, "--chunks"});
  EXPECT_EQ(info.exit_code, 0);
  for (const char* part : {"A ball", "40 × 40 × 40", "1 × 1 × 2", "HU", "lossless", "histogram",
                           "bands per block", "active cells"}) {
    EXPECT_NE(info.out.find(part), std::string::npos) << part << "\n" << info.out;
  }
  const auto json = nlohmann::json::parse(run({"info", store, "--json", "--chunks"}).out);
  EXPECT_EQ(json["kind"], "store");
  EXPECT_EQ(json["voxels"], (nlohmann::json{40, 40, 40}));
  EXPECT_EQ(json["metadata"]["title"], "A ball");
  EXPECT_GT(json["chunkReport"]["levels"][0]["chunks"], 0);
  const auto of_volume = nlohmann::json::parse(run({"info", volume, "--json"}).out);
  EXPECT_EQ(of_volume["kind"], "volume");
  EXPECT_EQ(of_volume["range"], json["range"]);
  EXPECT_EQ(of_volume["spacing"], (nlohmann::json{1.0, 1.0, 2.0}));
  EXPECT_EQ(of_volume["suggestedIsovalues"], json["metadata"]["suggested_isovalues"]);
  EXPECT_EQ(of_volume["histogram"], json["metadata"]["histogram"]);

  for (const bool exact : {false, true}) {
    const std::string ply = folder / "ball.ply";
    std::vector<std::string> arguments{"extract", store, "--isovalue", "100.5", "-o", ply};
    if (exact) arguments.push_back("--exact");
    const Ended extracted = run(arguments);
    ASSERT_EQ(extracted.exit_code, 0) << extracted.err;
    const std::string bytes = read_file(ply);
    const size_t end = bytes.find("end_header\n") + 11;
    const size_t count = std::stoull(bytes.substr(bytes.find("vertex ") + 7, 20));
    ASSERT_GT(count, 1000u);
    ASSERT_EQ(bytes.size(), end + 24 * count);
    double worst = 0;
    for (size_t i = 0; i < count; ++i) {
      float v[6];
      std::memcpy(v, bytes.data() + end + 24 * i, 24);
      const double x = v[0] - 19.5, y = v[1] - 19.5, z = v[2] / 2 - 19.5;
      worst = std::max(worst, std::abs(std::hypot(x, y, z) - 99.5 * 40 / 300));
      EXPECT_NEAR(std::hypot(v[3], v[4], v[5]), 1, 1e-5);
      EXPECT_GT(v[3] * x + v[4] * y + v[5] * z, 0) << "normals point towards smaller values";
    }
    // Values are rounded to integers, and change by 7.5 per voxel. No point is outside of its cell.
    EXPECT_LT(worst, 0.35);
  }
  // At the edge of the ball, where values are clamped to 0, Newton steps are long.
  const auto count_of = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"extract", store, "-i", "1.5", "-o", folder / "ball.ply"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(run(arguments).exit_code, 0);
    const std::string bytes = read_file(folder / "ball.ply");
    return std::stoull(bytes.substr(bytes.find("vertex ") + 7, 20));
  };
  EXPECT_LT(count_of({"--drop-displaced"}), count_of({}));
  const Ended below = run({"extract", store, "-i", "-3.5", "-o", folder / "none.ply"});
  EXPECT_EQ(below.exit_code, 0) << below.err;
  EXPECT_NE(below.err.find("no isosurface"), std::string::npos);
  EXPECT_EQ(run({"extract", store, "-i", "5", "--level", "9", "-o", folder / "x.ply"}).exit_code,
            1);
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.isosplat", "ball.isosplat.webp",
                                                      "ball.nrrd", "ball.ply", "none.ply"}));
}

TEST(Cli, WritesArraysThatNumPyLoads) {
  const TempFolder folder;
  ASSERT_EQ(run({"build", write_ball(folder, 40), "-q"}).exit_code, 0);
  const std::string store = folder / "ball.isosplat";
  for (const char* name : {"p.npy", "p.npz"}) {
    const Ended written = run({"extract", store, "-i", "100.5", "-o", folder / name});
    EXPECT_EQ(written.exit_code, 0) << written.err;
  }
  EXPECT_EQ(run({"extract", store, "-i", "100.5", "--mesh", "-o", folder / "m.npz"}).exit_code, 0);
  // Earlier versions wrote a PLY file under any name, without a message.
  EXPECT_EQ(run({"extract", store, "-i", "100.5", "-o", folder / "p.csv"}).exit_code, 2);
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0) {
    GTEST_SKIP() << "NumPy is missing: python3-numpy";
  }
  const std::string script = folder / "load.py";
  write_file(script, R"(import numpy, sys
folder = sys.argv[1]
points = numpy.load(folder + "/p.npy")
arrays = numpy.load(folder + "/p.npz")
assert len(points) > 1000 and points.dtype.names == ("position", "normal", "value")
assert (arrays["positions"] == points["position"]).all()
assert (arrays["normals"] == points["normal"]).all()
assert (points["value"] == 100.5).all() and arrays["isovalue"] == 100.5
radius = numpy.linalg.norm(points["position"] / [1, 1, 2] - 19.5, axis=1)
assert abs(radius - 99.5 * 40 / 300).max() < 0.35
mesh = numpy.load(folder + "/m.npz")
corners = mesh["positions"][mesh["triangles"]]
assert len(corners) > 1000 and mesh["normals"].shape == mesh["positions"].shape
edges = numpy.sort(mesh["triangles"][:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
assert (numpy.unique(edges, axis=0, return_counts=True)[1] == 2).all(), "the mesh is closed"
)");
  EXPECT_EQ(
      std::system(
          ("/usr/bin/python3 " + script + " " + script.substr(0, script.rfind(char(47)))).c_str()),
      0);
}

TEST(Cli, NamesStoresAfterTheirVolumes) {
  const TempFolder folder;
  const std::string voxels = ball(8);
  const std::string npy_header = "{'descr': '|u1', 'fortran_order': False, 'shape': (8, 8, 8), }";
  std::string npy = std::string("\x93NUMPY\x01\x00\x76\x00", 10) + npy_header;
  npy.resize(127, ' ');
  write_file(folder / "a.npy", npy + "\n" + voxels);
  write_file(folder / "B.NRRD",
             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n" + voxels);
  for (const char* name : {"a.npy", "B.NRRD"}) {
    const Ended built = run({"build", folder / name, "-q"});
    EXPECT_EQ(built.exit_code, 0) << built.err;
  }
  for (const char* name : {"a.isosplat", "B.isosplat"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  }
}

TEST(Cli, WritesMeshes) {
  const TempFolder folder;
  ASSERT_EQ(run({"build", write_ball(folder, 40), "-q"}).exit_code, 0);
  const std::string store = folder / "ball.isosplat";
  const auto extract = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"extract", store, "-i", "100.5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  for (const char* name : {"b.ply", "b.STL", "b.obj", "b.glb", "b.3mf", "b.npz"}) {
    const Ended written = extract({"--mesh", "-o", folder / name});
    EXPECT_EQ(written.exit_code, 0) << written.err;
    EXPECT_NE(written.out.find(" triangles, "), std::string::npos) << written.out;
    EXPECT_EQ(extract({"--mesh", "-o", folder / name}).exit_code, 0) << "it replaces its own kind";
  }
  EXPECT_EQ(extract({"--mesh", "-o", folder / "b.vtk"}).exit_code, 2);

  const size_t all = read_file(folder / "b.glb").size();
  const Ended simple =
      extract({"--mesh", "--largest", "--simplify", "0.2", "-o", folder / "b.glb"});
  EXPECT_EQ(simple.exit_code, 0) << simple.err;
  EXPECT_NE(simple.err.find("kept 1 of 1 components"), std::string::npos) << simple.err;
  EXPECT_NE(simple.err.find("simplified; the largest quadric error (root mean square) is 0."),
            std::string::npos);
  EXPECT_LT(read_file(folder / "b.glb").size(), all / 2);

  // The file names the store, whose name need not be UTF-8.
  const std::string latin1 = folder / "b\xe9.isosplat";
  std::filesystem::copy_file(store, latin1);
  for (const char* isovalue : {"100.5", "-3.5"}) {
    const Ended written =
        run({"extract", latin1, "-i", isovalue, "--mesh", "-o", folder / "latin1.glb"});
    EXPECT_EQ(written.exit_code, 0) << written.err;
    const std::string glb = read_file(folder / "latin1.glb");
    EXPECT_NE(glb.find("b\xef\xbf\xbd.isosplat"), std::string::npos) << "U+FFFD";
  }

  // The whole ball, half of it, and a box without a surface.
  const std::string half = folder / "half.stl";
  EXPECT_EQ(extract({"--mesh", "-o", folder / "b.stl", "--box", "-9,-9,-9,99,99,99"}).exit_code, 0);
  EXPECT_EQ(read_file(folder / "b.stl"), read_file(folder / "b.STL"));
  const std::string half_box = "-9,-9,-9,19.5,99,99";
  EXPECT_EQ(extract({"--mesh", "--open", "-o", half, "--box", half_box}).exit_code, 0);
  EXPECT_NEAR(double(read_file(half).size()) / double(read_file(folder / "b.stl").size()), 0.5,
              0.03);
  const Ended empty = extract({"--mesh", "-o", half, "--box", "0,0,0,2,2,2"});
  EXPECT_EQ(empty.exit_code, 0);
  EXPECT_NE(empty.err.find("in --box"), std::string::npos) << empty.err;
  const Ended reversed = extract({"--mesh", "-o", half, "--box", "20,0,0,2,2,2"});
  EXPECT_EQ(reversed.exit_code, 2) << reversed.err;
  EXPECT_NE(reversed.err.find("found 20,0,0,2,2,2"), std::string::npos) << reversed.err;

  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--largest"},
                                                {"--box", "1,2,3"},
                                                {"--simplify", "1"},
                                                {"--mesh", "--simplify", "0"},
                                                {"--mesh", "--components", "0"},
                                                {"--mesh", "--components", "2", "--largest"}}) {
    const Ended refused = extract(wrong);
    EXPECT_EQ(refused.exit_code, 2) << refused.err;
    EXPECT_FALSE(refused.err.empty());
  }
}

TEST(Cli, ReadsRawVolumesAndReportsNumbersThatAreNotFinite) {
  const TempFolder folder;
  std::vector<float> values(20 * 20 * 20, 1);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i % 400);
  values[4000] = std::nanf("");
  values[4001] = INFINITY;
  write_file(folder / "v.raw", test::bytes_of(values));
  const std::vector<std::string> how{"--dims", "20x20x20", "--type", "f32"};
  std::vector<std::string> build{"build", folder / "v.raw"}, info{"info", folder / "v.raw"};
  build.insert(build.end(), how.begin(), how.end());
  info.insert(info.end(), how.begin(), how.end());
  const Ended built = run(build);
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.out.find("2 voxels are missing, infinite or not a number"), std::string::npos);
  EXPECT_NE(run(info).out.find("2 voxels"), std::string::npos);
  EXPECT_NE(run({"info", folder / "v.isosplat"}).out.find("lossless"), std::string::npos);
  build.insert(build.end(), {"--force", "--max-error", "2.5"});
  EXPECT_EQ(run(build).exit_code, 0);
  EXPECT_NE(run({"info", folder / "v.isosplat"}).out.find("values are within ±2 (16 bits"),
            std::string::npos);
  EXPECT_EQ(run({"verify", folder / "v.isosplat"}).exit_code, 0);
}

TEST(Cli, AFullDiskLeavesTheOldStoreAndNothingElse) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 70), store = folder / "ball.isosplat";
  write_file(store, "an older store");
  const Ended full = run(Call{.arguments = {"build", volume, "--force"}, .file_limit = 40000});
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_NE(full.err.find("free some space"), std::string::npos) << full.err;
  EXPECT_EQ(read_file(store), "an older store");
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.isosplat", "ball.nrrd"}));

  ASSERT_EQ(run({"build", volume, "--force", "--no-thumbnail"}).exit_code, 0);
  const Ended ply = run(Call{.arguments = {"extract", store, "-i", "100.5", "-o", folder / "p.ply"},
                             .file_limit = 4000});
  EXPECT_EQ(ply.exit_code, 1);
  const Ended demo =
      run(Call{.arguments = {"demo", folder.path(), "--only", "bucky"}, .file_limit = 4000});
  EXPECT_EQ(demo.exit_code, 1);
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.isosplat", "ball.nrrd"}));
}

/// Starts a build, and sends a signal while its temporary file exists. Tries again if the build
/// ended before the signal. If the build ignores hang-ups and the signal is a hang-up, the build
/// continues; then returns its regular end.
Ended interrupt_build(const TempFolder& folder, const std::string& volume, int signal,
                      bool ignores_hangup = false) {
  const TempFolder printed;
  const std::string out = printed / "out", err = printed / "err";
  const auto temporary_is_there = [&] {
    for (const std::string& name : folder.files()) {
      if (name.starts_with(".ball.isosplat.building-")) return true;
    }
    return false;
  };
  for (int attempt = 0; attempt < 100; ++attempt) {
    write_file(folder / "ball.isosplat", "an older store");
    const pid_t child =
        test::start(Call{.arguments = {"build", volume, "--force", "--threads", "1"},
                         .ignores_hangup = ignores_hangup},
                    out, err);
    siginfo_t ended{};
    while (ended.si_pid != child && !temporary_is_there()) {
      waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
    const bool is_in_time = ended.si_pid != child;
    kill(child, signal);
    const Ended end = test::wait_for(child, out, err);
    if (ignores_hangup ? is_in_time : end.signal == signal) return end;
  }
  ADD_FAILURE() << "no build was running when the signal was sent";
  return {};
}

TEST(Cli, AnInterruptedBuildLeavesTheOldStoreAndCanBeRepeated) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 150), store = folder / "ball.isosplat";
  ASSERT_EQ(run({"build", volume, "--no-thumbnail"}).exit_code, 0);
  const std::string whole = read_file(store);
  const std::vector<std::string> both{"ball.isosplat", "ball.nrrd"};
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    interrupt_build(folder, volume, signal);
    EXPECT_EQ(read_file(store), "an older store");
    EXPECT_EQ(folder.files(), both) << "files are left after " << strsignal(signal);
  }
  interrupt_build(folder, volume, SIGKILL);
  EXPECT_EQ(read_file(store), "an older store");
  EXPECT_EQ(folder.files().size(), 3u)
      << "after SIGKILL, the program cannot remove its temporary file";
  ASSERT_EQ(run({"build", volume, "--force", "--no-thumbnail"}).exit_code, 0);
  EXPECT_EQ(read_file(store), whole) << "the same input gives the same bytes";
  EXPECT_EQ(folder.files(), both) << "the next build removes what the killed one left";
}

TEST(Cli, AnIgnoredHangUpDoesNotEndABuild) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 150), store = folder / "ball.isosplat";
  const Ended ended = interrupt_build(folder, volume, SIGHUP, true);  // as under nohup
  EXPECT_EQ(ended.exit_code, 0) << ended.signal;
  EXPECT_EQ(run({"verify", store}).exit_code, 0);
}

TEST(Cli, TooLittleMemoryIsReportedBeforeAnythingIsWritten) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 100);
  const Ended ended = run({"build", volume, "--memory", "1M"});
  EXPECT_EQ(ended.exit_code, 1);
  // Progress may have been printed; the error is exactly the last line.
  ASSERT_TRUE(ended.err.ends_with('\n')) << ended.err;
  const std::string error = ended.err.substr(ended.err.rfind('\n', ended.err.size() - 2) + 1);
  EXPECT_TRUE(error.starts_with("isosplat: ")) << ended.err;
  EXPECT_NE(error.find("--memory"), std::string::npos) << ended.err;
  EXPECT_EQ(folder.files(), std::vector<std::string>{"ball.nrrd"});
}

TEST(Cli, DemoVolumesBuildAndVerify) {
  const TempFolder folder;
  const Ended demo = run({"demo", folder / "new" / "folder", "--only", "bucky,marschner_lobb"});
  EXPECT_EQ(demo.exit_code, 0) << demo.err;
  EXPECT_EQ(lines(demo.out), 2u);
  for (const char* name : {"bucky", "marschner_lobb"}) {
    const std::string volume = folder / "new" / "folder" / (std::string(name) + ".nrrd");
    EXPECT_EQ(run({"build", volume, "-q", "--force", "-o", folder / "s.isosplat"}).exit_code, 0);
    EXPECT_EQ(run({"verify", folder / "s.isosplat"}).exit_code, 0);
  }
}

TEST(Cli, ServesUntilItIsStopped) {
  const TempFolder folder;
  ASSERT_EQ(run({"build", write_ball(folder, 20)}).exit_code, 0);
  const Ended served = serve_until_logged(
      Call{.arguments = {"serve", folder.path(), "--port", "0"}}, "volume ball: ");
  EXPECT_EQ(served.exit_code, 0) << served.err;
  EXPECT_NE(served.err.find("volume ball: "), std::string::npos) << served.err;
  const TempFolder empty;
  const Ended waiting = serve_and_stop(Call{.arguments = {"serve", empty.path(), "--port", "0"}});
  EXPECT_EQ(waiting.exit_code, 0) << waiting.err;
  EXPECT_NE(waiting.err.find("no store and no scene yet"), std::string::npos) << waiting.err;
}

TEST(Cli, AServerForOthersNeedsCorsOrPublic) {
  const TempFolder folder;
  const Ended refused = run({"serve", folder.path(), "--port", "0", "--host", "0.0.0.0"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("--cors none"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--public"), std::string::npos) << refused.err;
  const Ended chosen = serve_and_stop(Call{
      .arguments = {"serve", folder.path(), "--port", "0", "--host", "0.0.0.0", "--cors", "none"}});
  EXPECT_EQ(chosen.exit_code, 0) << chosen.err;
  EXPECT_NE(chosen.err.find("warning: everyone who reaches 0.0.0.0"), std::string::npos);
  for (const std::vector<std::string>& options : {std::vector<std::string>{"--cors", "a.example"},
                                                  {"--allow-host", "a:b"},
                                                  {"--cors", "*", "--public"}}) {
    std::vector<std::string> arguments = {"serve", folder.path(), "--port", "0"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    EXPECT_EQ(run(arguments).exit_code, 2) << options[0];
  }
}

TEST(Cli, SignLinkPrintsAnAddress) {
  const TempFolder folder;
  const std::string key = folder / "key";
  write_file(key, std::string(64, 'k') + "\n");
  const Ended link = run({"sign-link", "head-1", "--link-key-file", key, "--expires", "2h", "--url",
                          "https://a.example/volumes"});
  EXPECT_EQ(link.exit_code, 0) << link.err;
  EXPECT_TRUE(link.out.starts_with("https://a.example/volumes/?volume=head-1&exp=")) << link.out;
  // The volume's name depends on the folders that the server serves: another store could have the
  // same name.
  for (const char* const other :
       {"stores/head-1.isosplat", "head 1", "head-1.isosplat", "a/b", ""}) {
    const Ended refused = run({"sign-link", other, "--link-key-file", key});
    EXPECT_EQ(refused.exit_code, 2) << other;
    EXPECT_EQ(refused.out, "") << other;
  }
  const std::string signature = link.out.substr(link.out.find("&sig=") + 5);
  EXPECT_EQ(signature.size(), 65u) << link.out;
  // A store of a subfolder: by its name, or by its path and the folder that is served.
  const std::string stores = folder / "stores";
  for (const char* const name : {"ct", "Müller", "Möller"}) {
    std::filesystem::create_directories(folder.path() / "stores" / name);
    write_file(stores + "/" + name + "/head 1.isosplat", "");
  }
  write_file(stores + "/ct/head-1.isosplat", "");
  for (const std::vector<std::string>& volume : std::vector<std::vector<std::string>>{
           {"ct~head-1"}, {stores + "/ct/head-1.isosplat", "--folder", stores + "/"}}) {
    std::vector<std::string> arguments = {"sign-link", "--link-key-file", key};
    arguments.insert(arguments.end(), volume.begin(), volume.end());
    const Ended below = run(arguments);
    EXPECT_NE(below.out.find("/?volume=ct~head-1&exp="), std::string::npos)
        << below.out << below.err;
  }
  // Folders whose names have characters that names of volumes cannot have.
  std::set<std::string> names;
  for (const char* const name : {"Müller", "Möller"}) {
    const Ended other = run({"sign-link", stores + "/" + name + "/head 1.isosplat", "--folder",
                             stores, "--link-key-file", key});
    EXPECT_NE(other.out.find("?volume=M-ller--"), std::string::npos) << other.out << other.err;
    names.insert(other.out.substr(0, other.out.find("&exp=")));
  }
  EXPECT_EQ(names.size(), 2u);
  // If two folders are served, names begin with the folder.
  const std::string mr = folder / "mr";
  std::filesystem::create_directories(mr);
  const Ended both = run({"sign-link", stores + "/ct/head-1.isosplat", "--folder", stores,
                          "--folder", mr, "--link-key-file", key});
  EXPECT_NE(both.out.find("/?volume=stores~ct~head-1&exp="), std::string::npos) << both.err;
  for (const std::string& missing :
       {stores + "/../other/head.isosplat", stores + "/ct/foot.isosplat"}) {
    const Ended refused = run({"sign-link", missing, "--folder", stores, "--link-key-file", key});
    EXPECT_EQ(refused.exit_code, 2) << missing;
    EXPECT_NE(refused.err.find("--folder"), std::string::npos) << refused.err;
  }
  write_file(key, "short");
  EXPECT_EQ(run({"sign-link", "head", "--link-key-file", key}).exit_code, 2);
  EXPECT_EQ(run({"sign-link", "head", "--link-key-file", folder / "none"}).exit_code, 1);
  EXPECT_EQ(run({"sign-link", "head"}).exit_code, 2) << "no key";
  write_file(key, std::string(64, 'k'));
  for (const char* time : {"", "7", "d", "0d", "-1d", "1.5h", "4000d", "99999999999999999999d"}) {
    EXPECT_EQ(run({"sign-link", "head", "--link-key-file", key, "--expires", time}).exit_code, 2)
        << time;
  }
}

TEST(Cli, ViewBuildsOnceIntoTheCache) {
  const TempFolder folder, cache;
  const std::string volume = write_ball(folder, 20);
  const Call call{.arguments = {"view", volume, "--port", "0"}, .cache = cache.path()};
  const Ended first = serve_and_stop(call);
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_NE(first.out.find("/?token="), std::string::npos) << first.out;
  EXPECT_NE(first.out.find("&volume=ball"), std::string::npos) << first.out;
  EXPECT_NE(first.err.find("Building"), std::string::npos);
  const Ended second = serve_and_stop(call);
  EXPECT_EQ(second.err.find("Building"), std::string::npos) << second.err;

  for (const auto& entry : std::filesystem::directory_iterator(cache / "isosplat")) {
    std::filesystem::resize_file(entry, 1000);
  }
  EXPECT_NE(serve_and_stop(call).err.find("Building"), std::string::npos) << "of a damaged store";

  std::string longer = read_file(volume);
  longer.insert(longer.find('\n') + 1, "# another size\n");
  write_file(volume, longer);
  EXPECT_NE(serve_and_stop(call).err.find("Building"), std::string::npos);
  const Call other{.arguments = {"view", volume, "--port", "0", "--spacing", "1,1,3"},
                   .cache = cache.path()};
  EXPECT_NE(serve_and_stop(other).err.find("Building"), std::string::npos);
  size_t stores = 0;
  for (const auto& entry : std::filesystem::directory_iterator(cache / "isosplat")) {
    stores += entry.path().extension() == ".isosplat";
  }
  EXPECT_EQ(stores, 3u);
  EXPECT_EQ(folder.files(), std::vector<std::string>{"ball.nrrd"}) << "nothing beside the volume";
}

TEST(Cli, RealVolumesBuildAndVerify) {
  ISOSPLAT_NEEDS_VOLUMES(volumes);
  const TempFolder folder;
  for (const char* name : {"fuel.nhdr", "engine.nhdr", "aneurysm.nhdr", "lobster.nhdr",
                           "statueLeg.nhdr", "neghip.nhdr", "mni152.nii.gz", "mr_t1_dicom",
                           "cthead_tif", "iron_protein.vtk", "fetal_atlas_f32.nrrd"}) {
    SCOPED_TRACE(name);
    const std::string store = folder / "v.isosplat";
    const Ended built = run({"build", volumes / name, "-o", store, "-q", "--force"});
    EXPECT_EQ(built.exit_code, 0) << built.err;
    if (std::filesystem::file_size(store) > 4'000'000) continue;  // larger stores take long
    const Ended verified = run({"verify", store});
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
  }
}

TEST(Cli, NotesOfAVolumeStayInItsStoreAndQuietPrintsNone) {
  const TempFolder folder;
  write_file(folder / "ball_16x16x16_uint8.raw", ball(16));
  const std::string volume = folder / "ball_16x16x16_uint8.raw", store = folder / "ball.isosplat";
  const std::string note = "taken from the file's name";
  EXPECT_NE(run({"build", volume, "-o", store}).err.find(note), std::string::npos);
  EXPECT_NE(run({"info", volume}).out.find(note), std::string::npos);
  EXPECT_NE(run({"info", store}).out.find(note), std::string::npos);
  const auto json = nlohmann::json::parse(run({"info", store, "--json"}).out);
  const auto& notes = json["metadata"]["notes"];
  ASSERT_EQ(notes.size(), 2u);  // the dimensions and type; the spacing, which is assumed
  EXPECT_NE(notes[0].get<std::string>().find(note), std::string::npos);
  EXPECT_NE(notes[1].get<std::string>().find("no voxel spacing"), std::string::npos);
  const Ended quiet = run({"build", volume, "-o", store, "--quiet"});
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.out + quiet.err, "");
  EXPECT_NE(run({"info", store}).out.find(note), std::string::npos);
}

TEST(Cli, MissingValuesAreNumbersOrNone) {
  const TempFolder folder;
  write_file(folder / "ball_16x16x16_uint8.raw", ball(16));
  const std::string volume = folder / "ball_16x16x16_uint8.raw";
  const Ended wrong = run({"info", volume, "--missing-value", "nan"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("expected a number such as -9999, or none"), std::string::npos);
  EXPECT_EQ(run({"info", volume, "--missing-value", "none", "--allow-gaps"}).exit_code, 0);
}

}  // namespace
}  // namespace isosplat
