#include <sys/stat.h>

#include <cstring>
#include <fstream>

#include "tests/native/cli_program.h"

// The files that the program writes, and those that it never overwrites.
namespace isosplat {
namespace {

using test::ball;
using test::Call;
using test::Ended;
using test::read_file;
using test::run;
using test::serve_and_stop;
using test::TempFolder;
using test::write_ball;
using test::write_file;

/// Writes a header that names the file with the voxels. Both are in `folder`.
std::string write_detached(const TempFolder& folder, int n, const std::string& data_file) {
  write_file(folder / data_file, ball(n));
  const std::string header = folder / "ball.nhdr";
  write_file(header, fmt::format("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {0} {0} {0}\n"
                                 "encoding: raw\ndata file: {1}\n",
                                 n, data_file));
  return header;
}

/// Writes a header with a list of slices slice0.raw, slice1.raw, …
std::string write_list(const TempFolder& folder, int n) {
  const std::string voxels = ball(n), header = folder / "list.mhd";
  const auto slice = static_cast<size_t>(n) * static_cast<size_t>(n);
  std::string text = fmt::format(
      "ObjectType = Image\nNDims = 3\nDimSize = {0} {0} {0}\nElementType = MET_UCHAR\n"
      "ElementDataFile = LIST\n",
      n);
  for (size_t z = 0; z < static_cast<size_t>(n); ++z) {
    const std::string name = fmt::format("slice{}.raw", z);
    write_file(folder / name, voxels.substr(z * slice, slice));
    text += name + "\n";
  }
  write_file(header, text);
  return header;
}

void expect_refused(const std::vector<std::string>& arguments, const std::string& why) {
  const Ended ended = run(arguments);
  EXPECT_EQ(ended.exit_code, 2) << ended.err;
  EXPECT_NE(ended.err.find(why), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("isosplat: "), std::string::npos) << ended.err;
}

TEST(CliFiles, BuildNeverWritesOverItsInput) {
  const TempFolder folder;
  const std::string header = write_detached(folder, 12, "voxels.raw");
  std::filesystem::create_symlink("voxels.raw", folder / "link");
  std::filesystem::create_hard_link(folder / "voxels.raw", folder / "hard");
  const auto before = folder.files();
  for (const char* output : {"voxels.raw", "ball.nhdr", "link", "hard", "../x/voxels.raw"}) {
    const std::string path = std::string(output).starts_with("..")
                                 ? folder.path() / ".." / folder.path().filename() / "voxels.raw"
                                 : folder / output;
    for (const bool force : {false, true}) {
      std::vector<std::string> arguments{"build", header, "-o", path};
      if (force) arguments.push_back("--force");
      expect_refused(arguments, "expected an output that is not an input");
    }
  }
  EXPECT_EQ(read_file(folder / "voxels.raw"), ball(12));
  EXPECT_EQ(folder.files(), before);

  const TempFolder listed;
  const std::string list = write_list(listed, 12);
  expect_refused({"build", list, "-o", listed / "slice7.raw", "--force"},
                 "expected an output that is not an input");
  EXPECT_EQ(std::filesystem::file_size(listed / "slice7.raw"), 144u);
}

TEST(CliFiles, ExtractAndRenderNeverWriteOverTheirStore) {
  const TempFolder folder;
  const std::string store = folder / "ball.isosplat";
  ASSERT_EQ(run({"build", write_ball(folder, 20)}).exit_code, 0);
  const std::string whole = read_file(store);
  std::filesystem::create_symlink(store, folder / "link.ply");
  std::filesystem::create_hard_link(store, folder / "hard.ply");
  for (const std::string& output :
       {store, (folder / "link.ply").string(), (folder / "hard.ply").string()}) {
    for (const char* command : {"extract", "render"}) {
      for (const char* force : {"", "--force"}) {
        std::vector<std::string> arguments{command, store, "-i", "100.5", "-o", output};
        if (*force) arguments.emplace_back(force);
        expect_refused(arguments, "expected an output that is not an input");
      }
    }
  }
  EXPECT_EQ(read_file(store), whole);
  // Nor do they replace other files without --force.
  write_file(folder / "notes.ply", "years of work");
  expect_refused({"extract", store, "-i", "100.5", "-o", folder / "notes.ply"}, "--force");
  expect_refused({"render", store, "-i", "100.5", "-o", folder / "notes.ply"}, "--force");
  EXPECT_EQ(read_file(folder / "notes.ply"), "years of work");
  const std::vector<std::string> extract{"extract", store, "-i",
                                         "100.5",   "-o",  folder / "points.ply"};
  EXPECT_EQ(run(extract).exit_code, 0);
  EXPECT_EQ(run(extract).exit_code, 0) << "a PLY file replaces a PLY file";
}

TEST(CliFiles, AStoreOfAnotherVolumeIsReplacedByForceOnly) {
  const TempFolder folder;
  const std::string first = write_ball(folder, 20, "head"), store = folder / "head.isosplat";
  ASSERT_EQ(run({"build", first, "-q"}).exit_code, 0);
  const std::string whole = read_file(store);
  const std::string second = folder / "head.mha";
  write_file(second,
             "ObjectType = Image\nNDims = 3\nDimSize = 20 20 20\nElementType = MET_UCHAR\n"
             "ElementDataFile = LOCAL\n" +
                 ball(20));
  expect_refused({"build", second}, "found a store of another volume, head.nrrd");
  EXPECT_EQ(read_file(store), whole);
  EXPECT_EQ(run({"build", first, "-q"}).exit_code, 0) << "of the same volume";
  EXPECT_EQ(read_file(store), whole);
  // The same volume by another path.
  std::filesystem::create_directory(folder / "below");
  EXPECT_EQ(run({"build", folder / "below" / ".." / "head.nrrd", "-o", store, "-q"}).exit_code, 0);
  // A volume of the same name in another folder is another volume.
  std::filesystem::copy_file(first, folder / "below" / "head.nrrd");
  expect_refused({"build", folder / "below" / "head.nrrd", "-o", store}, "--force");
  EXPECT_EQ(read_file(store), whole);
  EXPECT_EQ(run({"build", second, "--force", "-q"}).exit_code, 0);
  EXPECT_EQ(run({"build", second, "-q"}).exit_code, 0);

  write_file(folder / "notes.isosplat", "years of work");
  expect_refused({"build", first, "-o", folder / "notes.isosplat"}, "found another file");
  EXPECT_EQ(read_file(folder / "notes.isosplat"), "years of work");
  std::filesystem::resize_file(store, 3000);  // a truncated store: its volume is unknown
  expect_refused({"build", second}, "an unknown volume");
}

TEST(CliFiles, DemoVolumesReplaceOnlyThemselves) {
  const TempFolder folder;
  write_file(folder / "bucky.nrrd", "NRRD0004\na volume of somebody's own");
  expect_refused({"demo", folder.path(), "--only", "bucky"}, "--force");
  EXPECT_EQ(read_file(folder / "bucky.nrrd"), "NRRD0004\na volume of somebody's own");
  EXPECT_EQ(run({"demo", folder.path(), "--only", "bucky", "--force"}).exit_code, 0);
  EXPECT_EQ(run({"demo", folder.path(), "--only", "bucky"}).exit_code, 0);
}

TEST(CliFiles, OutputsAreFilesOnly) {
  const TempFolder folder;
  ASSERT_EQ(run({"build", write_ball(folder, 20)}).exit_code, 0);
  const std::string store = folder / "ball.isosplat", pipe = folder / "pipe.ply";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::filesystem::create_directory(folder / "folder.ply");
  std::filesystem::create_symlink("/dev/null", folder / "null.ply");
  std::filesystem::create_symlink("circle.ply", folder / "circle.ply");
  const auto before = folder.files();
  for (const std::string& output :
       {(folder / "null.ply").string(), pipe, (folder / "folder.ply").string()}) {
    expect_refused({"extract", store, "-i", "100.5", "-o", output}, "expected the name of a file");
    expect_refused({"build", folder / "ball.nrrd", "-o", output}, "expected the name of a file");
  }
  EXPECT_EQ(run({"extract", store, "-i", "100.5", "-o", folder / "circle.ply"}).exit_code, 1);
  struct stat found {};
  ASSERT_EQ(lstat("/dev/null", &found), 0);
  EXPECT_TRUE(S_ISCHR(found.st_mode));
  ASSERT_EQ(lstat(pipe.c_str(), &found), 0);
  EXPECT_TRUE(S_ISFIFO(found.st_mode));
  EXPECT_EQ(folder.files(), before);
}

TEST(CliFiles, LinksStayLinksAndPermissionsStay) {
  const TempFolder folder;
  ASSERT_EQ(run({"build", write_ball(folder, 20)}).exit_code, 0);
  const std::string store = folder / "ball.isosplat";
  std::filesystem::create_directory(folder / "real");
  std::filesystem::create_symlink("real/points.ply", folder / "points.ply");
  std::filesystem::create_symlink("points.ply", folder / "again.ply");
  const auto extract = [&](const std::string& name) {
    const Ended ended = run({"extract", store, "-i", "100.5", "-o", folder / name});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
  };
  extract("again.ply");  // the target of the link does not exist yet
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "again.ply"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "points.ply"));
  EXPECT_TRUE(std::filesystem::is_regular_file(folder / "real" / "points.ply"));
  ASSERT_EQ(chmod((folder / "real" / "points.ply").c_str(), 0640), 0);
  write_file(folder / "real" / "points.ply", "ply\n");
  extract("points.ply");
  struct stat found {};
  ASSERT_EQ(stat((folder / "real" / "points.ply").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777u, 0640u);
  EXPECT_GT(found.st_size, 1000);
  const mode_t mask = umask(0027);
  extract("new.ply");
  umask(mask);
  ASSERT_EQ(stat((folder / "new.ply").c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777u, 0640u) << "0666 without the umask";
}

TEST(CliFiles, ProgramsThatWriteOneFileDoNotCollide) {
  const TempFolder folder, printed;
  const std::string volume = write_ball(folder, 60), store = folder / "ball.isosplat";
  write_file(folder / "ball.isosplat.part", "somebody's own");
  write_file(folder / "p.ply.part", "somebody's own");
  std::vector<pid_t> builds;
  for (int i = 0; i < 4; ++i) {
    builds.push_back(
        test::start(Call{.arguments = {"build", volume, "--force", "-q"}, .draws_thumbnails = true},
                    printed / std::to_string(i), printed / std::to_string(i)));
  }
  for (const pid_t build : builds) {
    EXPECT_EQ(test::wait_for(build, printed / "0", printed / "0").exit_code, 0);
  }
  EXPECT_EQ(run({"verify", store}).exit_code, 0);
  EXPECT_EQ(run({"extract", store, "-i", "100.5", "-o", folder / "p.ply"}).exit_code, 0);
  EXPECT_EQ(folder.files(),
            (std::vector<std::string>{"ball.isosplat", "ball.isosplat.part", "ball.isosplat.webp",
                                      "ball.nrrd", "p.ply", "p.ply.part"}));
  EXPECT_EQ(read_file(folder / "p.ply.part"), "somebody's own");
}

TEST(CliFiles, AnIgnoredHangUpStaysIgnored) {
  const TempFolder folder, cache;
  const std::string volume = write_ball(folder, 20);
  ASSERT_EQ(run({"build", volume}).exit_code, 0);
  for (const std::string command : {"serve", "view"}) {
    const Call call{
        .arguments = {command, command == "view" ? volume : folder.path().string(), "--port", "0"},
        .cache = cache.path()};
    const auto hang_up = [](pid_t child) { kill(child, SIGHUP); };
    EXPECT_EQ(serve_and_stop(call, hang_up).signal, SIGHUP);
    Call under_nohup = call;
    under_nohup.ignores_hangup = true;
    EXPECT_EQ(serve_and_stop(under_nohup, hang_up).exit_code, 0) << "SIGTERM, not SIGHUP, ended it";
  }
}

TEST(CliFiles, ViewRebuildsTheStoreWhenAnyFileOfTheVolumeHasChanged) {
  const TempFolder folder, cache;
  const auto builds = [&](const std::string& volume) {
    const Ended ended =
        serve_and_stop(Call{.arguments = {"view", volume, "--port", "0"}, .cache = cache.path()});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended.err.find("Building") != std::string::npos;
  };
  std::filesystem::create_directory(folder / "data");
  const std::string header = write_detached(folder, 12, "data/voxels.bin");
  EXPECT_TRUE(builds(header));
  EXPECT_FALSE(builds(header));
  std::string other = ball(12);
  other[700] = 3;
  write_file(folder / "data" / "voxels.bin", other);
  EXPECT_TRUE(builds(header));
  EXPECT_FALSE(builds(header));

  const TempFolder listed;
  const std::string list = write_list(listed, 12);
  EXPECT_TRUE(builds(list));
  EXPECT_FALSE(builds(list));
  write_file(listed / "slice5.raw", std::string(144, 'x'));
  EXPECT_TRUE(builds(list));
}

/// The positions of a PLY file with doubles or floats.
std::vector<std::array<double, 3>> positions_of(const std::string& bytes, bool& doubles) {
  const size_t end = bytes.find("end_header\n") + 11;
  const size_t count = std::stoull(bytes.substr(bytes.find("vertex ") + 7, 20));
  doubles = bytes.find("property double x\nproperty double y\nproperty double z\n") < end;
  const size_t stride = doubles ? 36 : 24;
  EXPECT_EQ(bytes.size(), end + stride * count);
  std::vector<std::array<double, 3>> positions(count);
  for (size_t i = 0; i < count; ++i) {
    if (doubles) {
      std::memcpy(positions[i].data(), bytes.data() + end + stride * i, 24);
    } else {
      float at[3];
      std::memcpy(at, bytes.data() + end + stride * i, 12);
      positions[i] = {at[0], at[1], at[2]};
    }
  }
  return positions;
}

TEST(CliFiles, PointsFarFromTheOriginAreExact) {
  const TempFolder folder;
  const auto extract = [&](const std::string& name, const std::string& origin, bool& doubles) {
    write_file(folder / (name + ".nrrd"),
               "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 30 30 30\n"
               "space: left-posterior-superior\n"
               "space directions: (0.25,0,0) (0,0.25,0) (0,0,0.25)\nspace origin: (" +
                   origin + ")\nencoding: raw\n\n" + ball(30));
    EXPECT_EQ(run({"build", folder / (name + ".nrrd"), "-q"}).exit_code, 0);
    const Ended ended = run(
        {"extract", folder / (name + ".isosplat"), "-i", "100.5", "-o", folder / (name + ".ply")});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return positions_of(read_file(folder / (name + ".ply")), doubles);
  };
  bool doubles = true;
  const auto near = extract("near", "0,0,0", doubles);
  EXPECT_FALSE(doubles) << "single precision is enough, at half the size";
  const auto far = extract("far", "500000,5200000,120", doubles);  // UTM metres
  EXPECT_TRUE(doubles);
  ASSERT_EQ(near.size(), far.size());
  ASSERT_GT(near.size(), 500u);
  const std::array<double, 3> origin{500000, 5200000, 120};
  double worst = 0;
  for (size_t i = 0; i < near.size(); ++i) {
    for (size_t axis = 0; axis < 3; ++axis) {
      worst = std::max(worst, std::abs(far[i][axis] - origin[axis] - near[i][axis]));
    }
  }
  EXPECT_LT(worst, 0.25 / 1000) << "a thousandth of a voxel";
}

}  // namespace
}  // namespace isosplat
