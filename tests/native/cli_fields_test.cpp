// isosplat build --field and extract --field.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/native/cli_program.h"
#include "tests/native/field_files.h"

namespace isosplat {
namespace {

using test::Ended;
using test::run;
using test::TempFolder;

class CliFields : public ::testing::Test {
 protected:
  Ended build(const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"build", volume, "-o", store, "--no-thumbnail"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run(arguments);
  }

  const TempFolder folder;
  const std::string store = folder / "x.isosplat", volume = test::write_ball(folder, 24);
  /// The number of vertices of a PLY file whose field "temperature", the last property, is x − 300.
  static size_t vertices_with_temperature(const std::string& ply) {
    EXPECT_NE(ply.find("property float nz\nproperty float temperature\n"), std::string::npos)
        << ply;
    const size_t count = std::stoul(ply.substr(ply.find("element vertex ") + 15, 20));
    const size_t begin = ply.find("end_header\n") + 11;
    for (size_t i = 0; i < count; ++i) {
      std::array<float, 7> vertex;
      std::memcpy(vertex.data(), &ply.at(begin + i * sizeof vertex), sizeof vertex);
      EXPECT_NEAR(vertex[6], vertex[0] - 300, 1e-3) << i;
      if (HasFailure()) return 0;
    }
    return count;
  }

  const std::string field = test::write_cube(
      folder, "t.nrrd", "int16", 24, test::cube<int16_t>(24, [](int i) { return i % 24 - 300; }));
};

TEST_F(CliFields, AreBuiltDescribedAndVerified) {
  const Ended built = build({"--field", "temperature=" + field, "--field", "same=" + volume});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.out.find("Field temperature: "), std::string::npos) << built.out;
  const Ended verified = run({"verify", store});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_NE(verified.out.find(" chunks of 2 fields"), std::string::npos) << verified.out;
  const Ended info = run({"info", store});
  EXPECT_NE(info.out.find("temperature: -300 to -277, lossless"), std::string::npos) << info.out;
  const auto json = nlohmann::json::parse(run({"info", store, "--json"}).out);
  ASSERT_EQ(json["fields"].size(), 2u);
  EXPECT_EQ(json["fields"][0]["name"], "temperature");
  EXPECT_EQ(json["fields"][0]["range"], (nlohmann::json{-300.0, -277.0}));
  EXPECT_EQ(json["fields"][1]["mapping"]["maxError"], 0.0);
  const auto queries = nlohmann::json::parse(
      run({"info", store, "--chunks", "--json"}).out)["chunkReport"]["queries"];
  uint64_t active = 0;
  for (const auto& query : queries) {
    active += query["activeCells"].get<uint64_t>();
    EXPECT_EQ(query["fieldBytes"]["temperature"].get<uint64_t>() > 0, query["chunks"] > 0);
  }
  EXPECT_GT(active, 0u);
}

TEST_F(CliFields, RefusesWhatItCannotBuild) {
  const auto expect_refused = [&](const std::vector<std::string>& options,
                                  const std::string& message) {
    const Ended refused = build(options);
    EXPECT_NE(refused.exit_code, 0);
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(store));
  };
  const std::string small = test::write_cube(folder, "s.nrrd", "uint8", 5,
                                             test::cube<uint8_t>(5, [](int i) { return i; }));
  expect_refused({"--field", "t=" + small}, "expected 24 × 24 × 24 voxels");
  expect_refused({"--field", field}, "expected a name and a volume");
  expect_refused({"--field", "a b=" + field}, "expected a name of at most 64 letters");
  expect_refused({"--field", "t=" + std::string(folder / "none.nrrd")}, "none.nrrd");
  expect_refused({"--field", "t=" + field, "--resume"}, "--resume or --part");
  expect_refused({"--field", "t=" + field, "--part", "1/2"}, "--resume or --part");
  expect_refused({"--field", "t=" + field, "--field", "t=" + field}, "with different names");
  expect_refused({"--field", "t=t_*.nrrd"}, "patterns and lists are for the time steps");
  const Ended overwritten =
      run({"build", volume, "-o", field, "--force", "--no-thumbnail", "--field", "t=" + field});
  EXPECT_NE(overwritten.exit_code, 0);
  EXPECT_EQ(run({"info", field}).exit_code, 0);
}

TEST_F(CliFields, OfOtherVoxelsAreResampled) {
  const std::string density = test::write_ramp(folder, "density.nrrd", 24, 1, "5");
  const auto built_with = [&](const std::string& dose) {
    return run({"build", density, "-o", store, "--no-thumbnail", "--field", "dose=" + dose});
  };
  const Ended built = built_with(test::write_ramp(folder, "dose.nrrd", 11, 2.5, "4"));
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find("field 'dose': resampled from 11 × 11 × 11 voxels"), std::string::npos)
      << built.err;
  // Both are the same function of the place.
  const std::string ply = folder / "a.ply";
  ASSERT_EQ(run({"extract", store, "-i", "151", "--mesh", "--field", "dose", "-o", ply}).exit_code,
            0);
  const auto vertices = test::vertices_of(ply);
  EXPECT_GT(vertices.size(), 400u);
  for (const auto& vertex : vertices) ASSERT_NEAR(vertex[6], 151, 0.01);
  const Ended partly = built_with(test::write_ramp(folder, "dose.nrrd", 6, 2.5, "4"));
  ASSERT_EQ(partly.exit_code, 0) << partly.err;
  EXPECT_NE(partly.err.find("% of the volume have no value of the field"), std::string::npos)
      << partly.err;
  const Ended elsewhere = built_with(test::write_ramp(folder, "dose.nrrd", 11, 2.5, "400"));
  EXPECT_NE(elsewhere.exit_code, 0);
  EXPECT_NE(elsewhere.err.find("places it elsewhere"), std::string::npos) << elsewhere.err;
}

TEST_F(CliFields, AreDerivedFromTheVolumeItself) {
  // The distance from a point, as far as voxels go.
  const std::string distance =
      test::write_cube(folder, "d.nrrd", "float", 24, test::cube<float>(24, [](int i) {
                         return 20 - std::hypot(i % 24 - 11.6, i / 24 % 24 - 11.2, i / 576 - 11.8);
                       }));
  ASSERT_EQ(run({"build", distance, "-o", store, "--no-thumbnail", "--field", "g=@gradient",
                 "--field", "c=@curvature"})
                .exit_code,
            0);
  for (const bool is_gradient : {true, false}) {
    const std::string ply = folder / "a.ply";
    const Ended done = run({"extract", store, "-i", "11", "--mesh", "--force", "--field",
                            is_gradient ? "g" : "c", "-o", ply});
    ASSERT_EQ(done.exit_code, 0) << done.err;
    const auto vertices = test::vertices_of(ply);
    EXPECT_GT(vertices.size(), 800u);
    for (const auto& vertex : vertices) {
      ASSERT_NEAR(vertex[6], is_gradient ? 1 : 1.0 / 9, is_gradient ? 0.02 : 0.01);
    }
  }
  const Ended unknown =
      run({"build", distance, "-o", store, "--no-thumbnail", "--field", "g=@torsion"});
  EXPECT_NE(unknown.err.find("expected @gradient, @curvature, @distance(FILE) or @labels(FILE)"),
            std::string::npos)
      << unknown.err;
  const Ended labels = run({"build", volume, "--labels", "-o", folder / "l.isobundle",
                            "--no-thumbnail", "--field", "g=@gradient"});
  EXPECT_NE(labels.err.find("nothing can be derived from labels"), std::string::npos) << labels.err;
}

TEST_F(CliFields, AreDistancesFromLabels) {
  // Label 1 begins at x = 16, label 2 at x = 21, on other voxels than the volume.
  const std::string labels = folder / "labels.nrrd";
  test::write_file(labels,
                   "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\n"
                   "sizes: 12 12 12\nspace directions: (2.5,0,0) (0,2.5,0) (0,0,2.5)\n"
                   "space origin: (4.75,4,4)\nencoding: raw\n\n" +
                       test::cube<uint8_t>(12, [](int i) {
                         return i % 12 < 5 ? 0 : i % 12 < 7 ? 1 : 2;
                       }));
  const std::string density = test::write_ramp(folder, "density.nrrd", 24, 1, "5");
  const auto built_with = [&](const std::string& text) {
    return run({"build", density, "-o", store, "--no-thumbnail", "--field", text});
  };
  const std::string ply = folder / "a.ply";
  for (const bool is_of_one : {false, true}) {
    const Ended built = built_with("d=@distance(" + labels + (is_of_one ? ",2)" : ")"));
    ASSERT_EQ(built.exit_code, 0) << built.err;
    EXPECT_NE(built.err.find("field 'd': resampled from 12 × 12 × 12"), std::string::npos)
        << built.err;
    ASSERT_EQ(run({"extract", store, "-i", "151", "--mesh", "--force", "--field", "d", "-o", ply})
                  .exit_code,
              0);
    const auto vertices = test::vertices_of(ply);
    ASSERT_GT(vertices.size(), 400u);
    // The isosurface is at one x.
    const double border = is_of_one ? 21 : 16;
    for (const auto& vertex : vertices) ASSERT_NEAR(vertex[6], border - vertex[0], 0.01);
  }
  for (const auto& [text, message] :
       {std::pair{"d=@distance(" + labels + ",7)", "without the labels"},
        {std::string("d=@distance"), "found '@distance'"},
        {std::string("d=@distance(,3)"), "found '@distance(,3)'"},
        {"d=@distance(" + labels + ",9007199254740993)", "at most ±2^53, found 9007199254740993"},
        {"d=@distance(" + labels, "found '@distance("}}) {
    const Ended refused = built_with(text);
    EXPECT_NE(refused.exit_code, 0) << text;
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
  }
}

TEST_F(CliFields, DistancesAreThoseOfThePlaceThatAnOptionSets) {
  const std::string ramp = test::write_cube(folder, "ramp.nrrd", "int16", 24,
                                            test::cube<int16_t>(24, [](int i) { return i % 24; }));
  // No value is taken for a missing one: those of the last slices are labels too.
  const std::string labels =
      test::write_cube(folder, "labels.nrrd", "int16", 24, test::cube<int16_t>(24, [](int i) {
                         return i % 24 < 8 ? 0 : i / 576 < 20 ? 1 : -9999;
                       }));
  ASSERT_EQ(run({"build", ramp, "-o", store, "--no-thumbnail", "--spacing", "2x2x2", "--field",
                 "d=@distance(" + labels + ")"})
                .exit_code,
            0);
  const std::string ply = folder / "a.ply";
  ASSERT_EQ(run({"extract", store, "-i", "15.5", "--mesh", "--force", "--field", "d", "-o", ply})
                .exit_code,
            0);
  const auto vertices = test::vertices_of(ply);
  ASSERT_GT(vertices.size(), 400u);
  for (const auto& vertex : vertices) {
    ASSERT_NEAR(vertex[0], 31, 1e-3);
    ASSERT_NEAR(vertex[6], -16, 0.01);
  }
}

TEST_F(CliFields, CategoriesHaveTheLabelsOfTheNearestVoxels) {
  const auto label_at = [](int x, int y, int z) {
    return std::array{0, 7, 9}[size_t(x + y + z) % 3];
  };
  const std::string labels = folder / "regions.nrrd", table = folder / "regions.csv";
  test::write_file(
      labels,
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\n"
      "sizes: 12 12 12\nspace directions: (2.5,0,0) (0,2.5,0) (0,0,2.5)\n"
      "space origin: (4.75,4.25,4.5)\nencoding: raw\n\n" +
          test::cube<uint8_t>(12, [&](int i) { return label_at(i % 12, i / 12 % 12, i / 144); }));
  test::write_file(table, "value,name,r,g,b\n7,thalamus,10,20,30\n8,other,1,2,3\n");
  const std::string density = test::write_ramp(folder, "density.nrrd", 24, 1, "5");
  const auto built_with = [&](const std::string& text) {
    return run({"build", density, "-o", store, "--no-thumbnail", "--field", text});
  };
  const Ended built = built_with("r=@labels(" + labels + "," + table + ")");
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find("each voxel of the volume has the nearest of its labels"),
            std::string::npos)
      << built.err;
  EXPECT_EQ(run({"verify", store}).exit_code, 0);
  const std::string ply = folder / "a.ply";
  const auto extract = [&](const char* level) {
    const Ended done = run({"extract", store, "-i", "151", "--mesh", "--level", level, "--force",
                            "--field", "r", "-o", ply});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return test::vertices_of(ply);
  };
  const auto finest = extract("0");
  EXPECT_GT(finest.size(), 400u);
  std::set<double> found;
  for (const auto& vertex : finest) {
    std::array<int, 3> label{};
    const std::array origin{4.75, 4.25, 4.5};
    for (size_t i = 0; i < 3; ++i) {
      const double voxel = std::round(double(vertex[i]) - 5);
      label[i] = static_cast<int>(std::round((voxel + 5 - origin[i]) / 2.5));
    }
    ASSERT_EQ(vertex[6], label_at(label[0], label[1], label[2]));
    found.insert(vertex[6]);
  }
  EXPECT_EQ(found, (std::set<double>{0, 7, 9}));
  // Coarse levels have labels, and no averages.
  found.clear();
  for (const auto& vertex : extract("1")) found.insert(vertex[6]);
  EXPECT_EQ(found, (std::set<double>{0, 7, 9}));
  // Vertices of cuts have labels too; inside of caps there are none.
  const Ended clipped = run({"extract", store, "-i", "151", "--mesh", "--closed", "--clip-plane",
                             "0,1,1,30.37", "--force", "--field", "r", "-o", ply});
  ASSERT_EQ(clipped.exit_code, 0) << clipped.err;
  found.clear();
  size_t cut = 0;
  for (const auto& vertex : test::vertices_of(ply)) {
    if (std::isnan(vertex[6])) continue;
    found.insert(vertex[6]);
    cut += std::abs(vertex[1] + vertex[2] - 30.37) < 1e-3;
  }
  EXPECT_EQ(found, (std::set<double>{0, 7, 9}));
  EXPECT_GT(cut, 20u);
  const Ended drawn = run({"render", store, "-i", "151", "--field", "r", "--size", "64x64", "-o",
                           folder / "a.png", "--force"});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_NE(drawn.out.find("field r: 3 categories"), std::string::npos) << drawn.out;
  const std::string fractions = test::write_cube(
      folder, "f.nrrd", "float", 24, test::cube<float>(24, [](int i) { return i / 7.0; }));
  const Ended refused = built_with("r=@labels(" + fractions + ")");
  EXPECT_NE(refused.err.find("expected labels, which are integers"), std::string::npos)
      << refused.err;
  EXPECT_NE(built_with("r=@labels(" + labels + ",none.csv)").exit_code, 0);
}

TEST_F(CliFields, OfLabelsAreDescribedAndRefusedBeforeTheBuild) {
  const auto built_with = [&](const std::string& text) { return build({"--field", text}); };
  const auto cube_of = [&](const char* type, const std::string& voxels) {
    return test::write_cube(folder, "labels.nrrd", type, 24, voxels);
  };
  const auto three = [](int i) { return i % 3 * 7; };
  const std::string labels = cube_of("int32", test::cube<int32_t>(24, three));
  ASSERT_EQ(built_with("r=@labels(" + labels + ")").exit_code, 0);
  EXPECT_NE(run({"info", store}).out.find(", 3 labels"), std::string::npos);
  const auto json = nlohmann::json::parse(run({"info", store, "--json"}).out);
  EXPECT_EQ(json["fields"][0].value("categories", 0), 3);
  const auto expect_refused = [&](const std::string& text, const std::string& message) {
    const Ended refused = built_with(text);
    EXPECT_NE(refused.exit_code, 0) << text;
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
  };
  expect_refused("r=@labels(" + labels + ",)", "expected the file of a table after the comma");
  // Extracted values are of single precision, which would make another label of this one.
  cube_of("int32", test::cube<int32_t>(24, [](int i) { return 16777200 + i % 18; }));
  expect_refused("r=@labels(" + labels + ")",
                 "expected labels of at most ±16777216 (2^24), found 16777217: number them anew");
}

TEST_F(CliFields, OfLabelsStayWithinTheirMemory) {
  // Of other voxels than the volume, whose slices alone exceed the limit.
  const std::string labels = folder / "labels.nrrd";
  constexpr size_t kEdge = 2600;
  test::write_file(labels, fmt::format("NRRD0004\ntype: uint8\ndimension: 3\nspace: "
                                       "left-posterior-superior\nsizes: {0} {0} 2\n"
                                       "space directions: (0.01,0,0) (0,0.01,0) (0,0,20)\n"
                                       "space origin: (1,1,1)\nencoding: raw\n\n",
                                       kEdge) +
                               std::string(2 * kEdge * kEdge, '\1'));
  const Ended refused = build({"--memory", "64M", "--field", "r=@labels(" + labels + ")"});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.err.find("found 64 MiB: raise the limit"), std::string::npos) << refused.err;
  EXPECT_LT(refused.peak_bytes, uint64_t{100} << 20);
}

TEST_F(CliFields, OfLabelsAreTheirPartsOfTheVolume) {
  // Label 1 lies in the field, label 2 in none of its voxels.
  const std::string labels = folder / "labels.nrrd", scene = folder / "labels.isobundle";
  test::write_file(
      labels,
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 24 24 24\n"
      "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (5,5,5)\nencoding: raw\n\n" +
          test::cube<uint8_t>(24, [](int i) {
            const int x = i % 24, y = i / 24 % 24, z = i / 576;
            if (std::min({x, y, z}) >= 3 && std::max({x, y, z}) < 9) return 1;
            return std::min({x, y, z}) >= 18 && std::max({x, y, z}) < 23 ? 2 : 0;
          }));
  const std::string dose = test::write_ramp(folder, "dose.nrrd", 7, 2.5, "4");
  const Ended built =
      run({"build", labels, "--labels", "-o", scene, "--no-thumbnail", "--field", "dose=" + dose});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_EQ(run({"verify", scene}).exit_code, 0);
  ASSERT_EQ(run({"extract", scene, "--mesh", "--open", "--field", "dose", "-o", folder / "a.ply"})
                .exit_code,
            0);
  const auto in = test::vertices_of(folder / "a-label_1.ply"),
             out = test::vertices_of(folder / "a-label_2.ply");
  EXPECT_GT(in.size(), 100u);
  EXPECT_GT(out.size(), 80u);
  for (const auto& vertex : in) ASSERT_NEAR(vertex[6], 10 * vertex[0], 0.01);
  for (const auto& vertex : out) ASSERT_TRUE(std::isnan(vertex[6]));
}

TEST_F(CliFields, OfLabelsReachTheBorderOfTheVolume) {
  const std::string labels = folder / "labels.nrrd", scene = folder / "labels.isobundle";
  test::write_file(
      labels,
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 24 24 24\n"
      "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (5,5,5)\nencoding: raw\n\n" +
          test::cube<uint8_t>(24, [](int i) { return i % 24 < 12 ? 1 : 0; }));
  const std::string dose = test::write_ramp(folder, "dose.nrrd", 24, 1, "5");
  ASSERT_EQ(
      run({"build", labels, "--labels", "-o", scene, "--no-thumbnail", "--field", "dose=" + dose})
          .exit_code,
      0);
  ASSERT_EQ(run({"extract", scene, "--mesh", "--open", "--field", "dose", "-o", folder / "a.ply"})
                .exit_code,
            0);
  const auto vertices = test::vertices_of(folder / "a.ply");
  EXPECT_GT(vertices.size(), 1500u);
  for (const auto& vertex : vertices) {
    ASSERT_NEAR(vertex[6], 10 * std::max(vertex[0], 5.0f), 0.1) << vertex[0];
  }
}

TEST_F(CliFields, OfVolumesWithAnotherSpacingHaveTheirVoxels) {
  const std::string density = test::write_ramp(folder, "density.nrrd", 24, 1, "5");
  const auto build_with = [&](const std::string& other) {
    return run({"build", density, "-o", store, "--no-thumbnail", "--spacing", "3,3,3", "--field",
                "t=" + other});
  };
  const Ended built = build_with(density);
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find("its voxels are taken"), std::string::npos) << built.err;
  EXPECT_NE(build_with(test::write_ramp(folder, "small.nrrd", 9, 1, "5")).exit_code, 0);
}

TEST_F(CliFields, OfTheSameVoxelsWithoutAPlaceAreTakenAsTheyAre) {
  const std::string density = test::write_ramp(folder, "density.nrrd", 24, 1, "5");
  for (const std::string& other : {field, test::write_ramp(folder, "dose.nrrd", 24, 1, "0")}) {
    const Ended built =
        run({"build", density, "-o", store, "--no-thumbnail", "--field", "t=" + other});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    EXPECT_NE(built.err.find("its voxels are taken for those of the volume"), std::string::npos)
        << built.err;
  }
}

TEST_F(CliFields, AreExtractedWithPointsAndMeshes) {
  ASSERT_EQ(build({"--field", "temperature=" + field}).exit_code, 0);
  const std::string ply = folder / "a.ply";
  const auto extract = [&](std::vector<std::string> options) {
    std::vector<std::string> arguments{"extract", store, "-i", "100.5", "--force", "-o"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run(arguments);
  };
  const auto expect_values = [&](std::vector<std::string> options) {
    options.insert(options.begin(), {ply, "--field", "temperature"});
    const Ended done = extract(options);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return vertices_with_temperature(test::read_file(ply));
  };
  EXPECT_GT(expect_values({}), 300u);
  EXPECT_GT(expect_values({"--exact"}), 300u);
  const size_t vertices = expect_values({"--mesh"});
  EXPECT_GT(vertices, 300u);
  EXPECT_GT(expect_values({"--mesh", "--closed"}), 300u);
  EXPECT_LT(expect_values({"--mesh", "--simplify", "0.3"}), vertices);
  const Ended unknown = extract({ply, "--field", "density"});
  EXPECT_NE(unknown.err.find("which has temperature"), std::string::npos) << unknown.err;
  const Ended stl = extract({folder / "a.stl", "--mesh", "--field", "temperature"});
  EXPECT_NE(stl.exit_code, 0);
  EXPECT_NE(stl.err.find("(.ply, .glb, .npz, .vtp)"), std::string::npos) << stl.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "a.stl"));
}

TEST_F(CliFields, ColourTheLayersOfScenes) {
  ASSERT_EQ(build({"--field", "temperature=" + field}).exit_code, 0);
  const std::string scene = folder / "scene.json", picture = folder / "a.png";
  const auto drawn = [&](const std::string& look, std::vector<std::string> options) {
    test::write_file(scene, R"({"format": "isosplat-scene", "version": 1, "layers": [
      {"store": "x.isosplat", "surfaces": [{"isovalue": 100.5}]}], "look": {)" +
                                look + "}}");
    options.insert(options.begin(),
                   {"render", scene, "-o", picture, "--size", "160x120", "--force"});
    const Ended ended = run(options);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended.exit_code == 0 ? test::read_file(picture) : std::string();
  };
  const std::string by_field = R"("colour_by": "field", "field": {"name": "temperature")";
  const std::string plain = drawn("", {});
  const std::string stated =
      drawn(by_field + R"(, "range": [-295, -280], "steps": 4, "lines": 2})", {});
  ASSERT_FALSE(stated.empty());
  EXPECT_FALSE(stated == plain);
  // The same as options, with and without another look in the scene.
  const std::vector<std::string> options{
      "--field",       "temperature", "--field-steps",          "4",
      "--field-lines", "2",           "--field-range=-295,-280"};
  EXPECT_TRUE(drawn("", options) == stated);
  EXPECT_TRUE(drawn(by_field + "}", options) == stated);
  EXPECT_FALSE(drawn(by_field + "}", {}) == stated);
  EXPECT_TRUE(drawn(by_field + "}", {"--colour-by", "isosurface"}) == plain);
  const Ended ranged = run({"render", scene, "-o", picture, "--force", "--range", "0,1"});
  EXPECT_NE(ranged.exit_code, 0);
  EXPECT_NE(ranged.err.find("--field temperature --field-range"), std::string::npos) << ranged.err;
  // Stores without the field have the colours of their surfaces, in the light of fields.
  const std::string other = drawn(R"("colour_by": "field", "field": {"name": "other"})", {});
  EXPECT_FALSE(other == stated);
  const Ended ended = run({"render", scene, "-o", picture, "--size", "160x120", "--force"});
  EXPECT_NE(ended.err.find("no visible layer has values of the field 'other'"), std::string::npos)
      << ended.err;
}

TEST_F(CliFields, AreExtractedFromTheLayersOfScenes) {
  ASSERT_EQ(build({"--field", "temperature=" + field}).exit_code, 0);
  const std::string plain = folder / "plain.isosplat", scene = folder / "scene.json";
  ASSERT_EQ(run({"build", volume, "-o", plain, "--no-thumbnail"}).exit_code, 0);
  test::write_file(scene, R"({"format": "isosplat-scene", "version": 1, "layers": [
    {"name": "with", "store": "x.isosplat", "surfaces": [{"isovalue": 100.5}]},
    {"name": "without", "store": "plain.isosplat", "surfaces": [{"isovalue": 100.5}]}]})");
  const Ended ended =
      run({"extract", scene, "--mesh", "--field", "temperature", "-o", folder / "a.ply"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("has no field 'temperature'"), std::string::npos) << ended.err;
  EXPECT_GT(vertices_with_temperature(test::read_file(folder / "a-with.ply")), 300u);
  EXPECT_EQ(test::read_file(folder / "a-without.ply").find("temperature"), std::string::npos);
  const Ended glb =
      run({"extract", scene, "--mesh", "--field", "temperature", "-o", folder / "a.glb"});
  ASSERT_EQ(glb.exit_code, 0) << glb.err;
  const std::string bytes = test::read_file(folder / "a.glb");
  uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  const auto json = nlohmann::json::parse(bytes.substr(20, length));
  const auto attributes = [&](size_t mesh) {
    return json["meshes"][mesh]["primitives"][0]["attributes"];
  };
  EXPECT_TRUE(attributes(0).contains("_TEMPERATURE"));
  EXPECT_FALSE(attributes(1).contains("_TEMPERATURE"));
  const Ended unknown = run({"extract", scene, "--mesh", "--field", "x", "-o", folder / "b.ply"});
  EXPECT_NE(unknown.err.find("expected a field of a store of the chosen layers"), std::string::npos)
      << unknown.err;
}

}  // namespace
}  // namespace isosplat
