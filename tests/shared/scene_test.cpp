// Scenes and headers of bundles, valid and damaged. The same tests run in WebAssembly.
#include "shared/core/scene/scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "shared/core/base/matrix3.h"
#include "shared/core/scene/bundle_header.h"
#include "shared/core/store/byte_order.h"
#include "shared/core/store/checksum.h"

namespace isosplat {
namespace {

std::string scene_of(const std::string& layers, const std::string& more = "") {
  return R"({"format":"isosplat-scene","version":1,"layers":)" + layers + more + "}";
}

std::string error_of(const std::string& text) {
  const auto scene = parse_scene(text);
  return scene ? "" : scene.error().message;
}

TEST(Scene, HasLayersWithSurfacesAndTransforms) {
  const auto scene = parse_scene(scene_of(
      R"([{"name":"bone","group":"CT","part_of":"head","store":"a.isosplat",
           "label":{"value":-5,"voxels":9007199254740992,"volume":0.25},"surfaces":[
            {"isovalue":1250.5,"colour":"#d9CCb3","opacity":0.5},{"isovalue":-3}]},
          {"store":"https://example.org/b.isosplat","visible":false,
           "transform":[1,0,0,5, 0,2,0,6, 0,0,3,7, 0,0,0,1]}])",
      R"(,"name":"Head","future":[1,{"x":null}],"background":"#01020380",
         "camera":{"target":[1,2,3],"distance":4,"elevation":-90,"orthographic":true},
         "clip":{"box":{"low":[0,0.25,0],"high":[1,1,0.5]},"caps":true,
                 "planes":[{"normal":[0,0,1],"offset":-2}]})"));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->name, "Head");
  ASSERT_EQ(scene->layers.size(), 2u);
  const SceneLayer& bone = scene->layers[0];
  EXPECT_EQ(bone.name, "bone");
  EXPECT_EQ(bone.group, "CT");
  EXPECT_EQ(bone.part_of, "head");
  EXPECT_EQ(bone.stores, std::vector<std::string>{"a.isosplat"});
  ASSERT_EQ(bone.surfaces.size(), 2u);
  EXPECT_EQ(bone.surfaces[0].isovalue, 1250.5);
  EXPECT_EQ(bone.surfaces[0].opacity, 0.5f);
  EXPECT_FLOAT_EQ((*bone.surfaces[0].colour)[1], 0xcc / 255.0f);
  EXPECT_FALSE(bone.surfaces[1].colour);
  EXPECT_TRUE(bone.visible);
  ASSERT_TRUE(bone.label);
  EXPECT_EQ(bone.label->value, -5);
  EXPECT_EQ(bone.label->voxels, uint64_t{1} << 53);
  EXPECT_EQ(bone.label->volume, 0.25);
  EXPECT_FALSE(scene->layers[1].label);
  EXPECT_FALSE(scene->layers[1].visible);
  EXPECT_EQ((*scene->layers[1].transform)[7], 6);
  EXPECT_EQ(scene->camera->elevation, -90);
  EXPECT_TRUE(scene->camera->orthographic);
  EXPECT_EQ(scene->clip.low.y, 0.25);
  EXPECT_EQ(scene->clip.planes[0].offset, -2);
  EXPECT_TRUE(scene->clip.caps);
  EXPECT_FLOAT_EQ((*scene->background)[3], 0x80 / 255.0f);
}

TEST(Scene, HasSlicesLookAndMeasurements) {
  const auto scene = parse_scene(scene_of(
      R"([{"store":"a"}])",
      R"(,"slices":{"along":[0.5,null,1],"plane":{"normal":[0,0,2],"offset":-3},"range":[-1,4]},
         "look":{"kind":"automatic","shading":"exact","colour_by":"projection-error",
                 "colour_map":"turbo","light":{"azimuth":-180,"shadow_softness":0.5},
                 "eye_dome":0,"future":1},
         "measurements":[
           {"kind":"distance","text":"width","points":[
             {"position":[1,2,3],"value":-7,"normal":[0,0,1],"level":2,"layer":"a","voxel":[1,1,1],
              "field":{"name":"dose","value":2.5,"units":"Gy"}},
             {"position":[4,5,6]}]},
           {"kind":"note","text":"n","points":[{"position":[0,0,0],"more":true}]}])"));
  ASSERT_TRUE(scene) << scene.error().message;
  const SceneSlices& slices = scene->slices;
  EXPECT_EQ(slices.along[0], 0.5);
  EXPECT_FALSE(slices.along[1]);
  EXPECT_EQ(slices.along[2], 1);
  EXPECT_EQ(slices.plane->offset, -3);
  EXPECT_EQ(slices.range->high, 4);
  EXPECT_EQ(scene->look.kind, SceneSplats::automatic);
  EXPECT_EQ(scene->look.shading, SceneShading::exact);
  EXPECT_EQ(scene->look.colour_by, SceneColouring::projection_error);
  EXPECT_EQ(scene->look.colour_map, SceneColourMap::turbo);
  EXPECT_EQ(scene->look.light.azimuth, -180);
  EXPECT_EQ(scene->look.light.shadow_softness, 0.5);
  EXPECT_FALSE(scene->look.light.sky);
  EXPECT_EQ(scene->look.eye_dome, 0);
  ASSERT_EQ(scene->measurements.size(), 2u);
  const SceneMeasurement& width = scene->measurements[0];
  EXPECT_EQ(width.kind, SceneMeasurementKind::distance);
  EXPECT_EQ(width.text, "width");
  ASSERT_EQ(width.points.size(), 2u);
  EXPECT_EQ(width.points[0].value, -7);
  EXPECT_EQ(width.points[0].normal->z, 1);
  EXPECT_EQ(width.points[0].level, 2u);
  EXPECT_EQ(width.points[0].layer, "a");
  EXPECT_EQ(width.points[0].voxel->x, 1);
  ASSERT_TRUE(width.points[0].field.has_value());
  EXPECT_EQ(width.points[0].field->name, "dose");
  EXPECT_EQ(width.points[0].field->value, 2.5);
  EXPECT_EQ(width.points[0].field->units, "Gy");
  EXPECT_EQ(width.points[1].position.z, 6);
  EXPECT_FALSE(width.points[1].level);
}

TEST(Scene, HasTheFieldThatColoursShow) {
  const auto look = [](const std::string& members) {
    return scene_of(R"([{"store":"a"}])", R"(,"look":{)" + members + "}");
  };
  const auto plain = parse_scene(look(R"("colour_by":"field","field":{"name":"p"})"));
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(plain->look.colour_by, SceneColouring::field);
  EXPECT_EQ(plain->look.field->name, "p");
  EXPECT_FALSE(plain->look.field->range);
  EXPECT_EQ(plain->look.field->scale, SceneFieldScale::linear);
  EXPECT_EQ(plain->look.field->steps, 0);
  EXPECT_EQ(plain->look.field->lines, 0);
  const auto full = parse_scene(look(
      R"("field":{"name":"p","range":[0.5,20],"scale":"logarithmic","steps":12,"lines":0.25})"));
  ASSERT_TRUE(full) << full.error().message;
  EXPECT_EQ(full->look.field->range->low, 0.5);
  EXPECT_EQ(full->look.field->range->high, 20);
  EXPECT_EQ(full->look.field->scale, SceneFieldScale::logarithmic);
  EXPECT_EQ(full->look.field->steps, 12);
  EXPECT_EQ(full->look.field->lines, 0.25);

  const auto fault = [&](const std::string& field) {
    return error_of(look(R"("colour_by":"field","field":)" + field));
  };
  EXPECT_EQ(fault("null"), "scene: look.field: expected the field that colours show, found null");
  EXPECT_EQ(fault("3"), "scene: look.field: expected a field, found 3");
  EXPECT_EQ(fault("{}"),
            "scene: look.field.name: expected a text of at most 64 bytes, found nothing");
  EXPECT_EQ(fault(R"({"name":""})"),
            "scene: look.field.name: expected the name of a field, found \"\"");
  EXPECT_EQ(fault(R"({"name":"p","range":[2,1]})"),
            "scene: look.field.range[1]: expected a number above the first, found 1");
  EXPECT_EQ(fault(R"({"name":"p","range":["a",1]})"),
            "scene: look.field.range[0]: expected a finite number, found \"a\"");
  EXPECT_EQ(fault(R"({"name":"p","scale":"logarithmic","range":[0,1]})"),
            "scene: look.field.range[0]: expected a number above 0, for a logarithmic scale, "
            "found 0");
  EXPECT_EQ(fault(R"({"name":"p","steps":1})"),
            "scene: look.field.steps: expected 0, or 2 to 256 colours, found 1");
  EXPECT_EQ(fault(R"({"name":"p","steps":1e9})"),
            "scene: look.field.steps: expected 0, or 2 to 256 colours, found 1000000000.0");
  EXPECT_EQ(fault(R"({"name":"p","steps":2.5})"),
            "scene: look.field.steps: expected an integer from 0 to 2^53, found 2.5");
  EXPECT_EQ(fault(R"({"name":"p","lines":-1})"),
            "scene: look.field.lines: expected 0, or a number above 0, found -1");
  EXPECT_EQ(fault(R"({"name":"p","lines":"5"})"),
            "scene: look.field.lines: expected a finite number, found \"5\"");
}

TEST(Scene, FaultsOfThePictureNameTheMember) {
  const auto fault = [](const std::string& members) {
    return error_of(scene_of(R"([{"store":"a"}])", "," + members));
  };
  EXPECT_EQ(fault(R"("slices":{"along":[0.5,2,null]})"),
            "scene: slices.along[1]: expected a number from 0 to 1, found 2");
  EXPECT_EQ(fault(R"("slices":{"plane":{"normal":[0,0,0],"offset":1}})"),
            "scene: slices.plane.normal: expected a normal that is not 0, found a list of 3");
  EXPECT_EQ(fault(R"("slices":{"range":[2,2]})"),
            "scene: slices.range[1]: expected a number above the first, found 2");
  EXPECT_EQ(fault(R"("look":{"kind":"round"})"),
            "scene: look.kind: expected one of automatic, quad, ellipse, exact, found \"round\"");
  EXPECT_EQ(fault(R"("look":{"light":{"roughness":0}})"),
            "scene: look.light.roughness: expected a number from 0.1 to 1, found 0");
  EXPECT_EQ(fault(R"("measurements":[{"kind":"angle","points":[]}])"),
            "scene: measurements[0].points: expected a list of 3, found a list of 0");
  EXPECT_EQ(fault(R"("measurements":[{"kind":"note","points":[{"position":[0,0,0]}]}])"),
            "scene: measurements[0].text: expected the text of the note, found nothing");
  std::string point = R"({"position":[0,0,0]})", path, paths;
  for (int i = 0; i < 500; ++i) path += (i > 0 ? "," : "") + point;
  for (int i = 0; i < 21; ++i) {
    paths += std::string(i > 0 ? "," : "") + R"({"kind":"path","points":[)" + path + "]}";
  }
  EXPECT_EQ(fault("\"measurements\":[" + paths + "]"),
            "scene: measurements: expected at most 10000 points in all, found a list of 21");
}

TEST(Scene, HasAStoreForEachStep) {
  const std::string time = R"(,"time":{"steps":[0,0.5,2],"unit":"s"})";
  const auto scene = parse_scene(
      scene_of(R"([{"stores":["0.isosplat","1.isosplat","0.isosplat"]},{"store":"fixed"}])", time));
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->time->values, (std::vector<double>{0, 0.5, 2}));
  EXPECT_EQ(scene->time->unit, "s");
  EXPECT_EQ(store_paths(*scene), (std::vector<std::string>{"0.isosplat", "fixed", "1.isosplat"}));
  const auto later = parse_scene(scene_of(R"([{"stores":["0","1","2"]},{"store":"fixed"}])",
                                          R"(,"time":{"steps":[0,0.5,2],"step":1})"));
  ASSERT_TRUE(later) << later.error().message;
  EXPECT_EQ(store_paths(*later), (std::vector<std::string>{"1", "fixed", "2", "0"}));
  EXPECT_EQ(error_of(scene_of(R"([{"stores":["0","1"]}])", time)),
            "scene: layers[0].stores: expected a list of 3, found a list of 2");
  EXPECT_EQ(error_of(scene_of(R"([{"stores":["0"]}])", R"(,"time":{"steps":[1,1]})")),
            "scene: time.steps[1]: expected a number above that of the step before, found 1");
}

TEST(Scene, ShowsAStepFirst) {
  const auto first = [](const std::string& step) {
    const auto scene = parse_scene(
        scene_of(R"([{"store":"a"}])", R"(,"time":{"steps":[0,5,6],"step":)" + step + "}"));
    EXPECT_TRUE(scene) << step;
    return scene ? first_step(*scene) : 99;
  };
  EXPECT_EQ(first("2"), 2u);
  EXPECT_EQ(first("0"), 0u);
  // Steps that do not exist.
  for (const char* step : {"3", "-1", "1.5", "1e300", "\"1\"", "null", "[1]"}) {
    EXPECT_EQ(first(step), 0u) << step;
  }
  EXPECT_EQ(first_step(Scene{}), 0u);
}

TEST(Scene, FaultsNameTheMember) {
  const auto layer = [](const std::string& members) {
    return error_of(scene_of("[{\"store\":\"a\"" + members + "}]"));
  };
  EXPECT_EQ(error_of(""), "scene: expected JSON in UTF-8: check it with a JSON tool");
  EXPECT_EQ(error_of("[1]"), "scene: format: expected \"isosplat-scene\", found nothing");
  EXPECT_EQ(error_of(R"({"format":7})"), "scene: format: expected \"isosplat-scene\", found 7");
  EXPECT_EQ(error_of(R"({"format":"isosplat-scene","version":2})"),
            "scene: version: expected 1, found 2: use a newer Isosplat");
  EXPECT_EQ(parse_scene(R"({"format":"isosplat-scene","version":2})").error().status,
            Status::unsupported_version);
  EXPECT_EQ(error_of(R"({"format":"isosplat-scene","version":1})"),
            "scene: layers: expected a list of 1 to 4096, found nothing");
  EXPECT_EQ(error_of(scene_of("[]")),
            "scene: layers: expected a list of 1 to 4096, found a list of 0");
  EXPECT_EQ(error_of(scene_of("[3]")), "scene: layers[0]: expected a layer, found 3");
  EXPECT_EQ(error_of(scene_of("[{}]")),
            "scene: layers[0].store: expected a text of at most 1024 bytes, found nothing");
  EXPECT_EQ(layer(R"(,"visible":1)"), "scene: layers[0].visible: expected true or false, found 1");
  EXPECT_EQ(layer(R"(,"surfaces":[{"isovalue":"x"}])"),
            "scene: layers[0].surfaces[0].isovalue: expected a finite number, found \"x\"");
  EXPECT_EQ(layer(R"(,"surfaces":[{"isovalue":1,"opacity":2}])"),
            "scene: layers[0].surfaces[0].opacity: expected a number from 0 to 1, found 2");
  EXPECT_EQ(layer(R"(,"surfaces":[{"isovalue":1,"colour":"red"}])"),
            "scene: layers[0].surfaces[0].colour: expected a colour as #rrggbb, found \"red\"");
  EXPECT_EQ(layer(R"(,"transform":[1,2])"),
            "scene: layers[0].transform: expected a list of 16, found a list of 2");
  EXPECT_EQ(layer(R"(,"transform":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,1,1])"),
            "scene: layers[0].transform[14]: expected 0, found 1");
  EXPECT_NE(layer(R"(,"surfaces":[1,2,3,4,5,6,7,8,9])"), "");
  EXPECT_NE(error_of(std::string(kMaxSceneBytes + 1, ' ')), "");
}

TEST(Scene, AnyDamageIsAnErrorOrAScene) {
  const std::string valid = scene_of(
      R"([{"name":"a","stores":["1","2"],"surfaces":[{"isovalue":1,"colour":"#aabbcc"}],
           "transform":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}])",
      R"(,"time":{"steps":[1,2]},"clip":{"box":{"low":[0,0,0],"high":[1,1,1]}})");
  ASSERT_TRUE(parse_scene(valid));
  std::mt19937 random(3);
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = valid;
    for (int edits = 1 + i % 3; edits > 0; --edits) {
      const size_t at = random() % damaged.size();
      if (random() % 2 == 0) {
        damaged[at] = static_cast<char>(random());
      } else {
        damaged.erase(at, 1 + random() % 20);
      }
      if (damaged.empty()) break;
    }
    const auto scene = parse_scene(damaged);
    if (!scene) {
      EXPECT_TRUE(scene.error().message.starts_with("scene: "));
    }
  }
  std::string deep = scene_of("[{\"store\":\"a\"}]",
                              ",\"deep\":" + std::string(100000, '[') + std::string(100000, ']'));
  EXPECT_TRUE(parse_scene(deep));
}

TEST(Scene, IsDistinguishedFromOtherFilesByItsFirstBytes) {
  EXPECT_TRUE(looks_like_scene("{\"format\":"));
  EXPECT_TRUE(looks_like_scene("\xEF\xBB\xBF\r\n\t {\"name\":\"ä\""));
  for (const std::string_view other :
       {std::string_view("NRRD0004"), std::string_view("[{}]"), std::string_view(""),
        std::string_view("  "), std::string_view("{{{\0{{", 6), std::string_view("{\x01")}) {
    EXPECT_FALSE(looks_like_scene(other)) << other;
  }
}

TEST(Scene, PathsStayBelowTheFolder) {
  for (const char* path : {"a", "a/b.isosplat", "stores/CT 1/ä.isosplat", "..a/b..", "a/...x"}) {
    EXPECT_TRUE(is_path_below(path)) << path;
  }
  for (const char* path : {"", "/a", "a/", "a//b", ".", "./a", "..", "a/..", "../a", "a/../b",
                           "C:/a", "a\\b", "https://x/a", "a\nb"}) {
    EXPECT_FALSE(is_path_below(path)) << path;
  }
  EXPECT_FALSE(is_path_below(std::string(1025, 'a')));
}

TEST(Scene, ATransformedGridHasTransformedPositions) {
  VolumeGrid grid{{5, 6, 7}, {1, 2, 3}, {4, 5, 6}};
  const AffineTransform transform{0, -2, 0.5, 7, 1, 0, 0, 8, 0, 0.25, 3, 9, 0, 0, 0, 1};
  const auto moved = transformed(grid, transform);
  ASSERT_TRUE(moved) << moved.error().message;
  EXPECT_TRUE(is_basis(moved->direction));
  for (const Vec3d index : {Vec3d{0, 0, 0}, Vec3d{4, 0, 2}, Vec3d{1, 5, 6}}) {
    const Vec3d p = grid.world(index), q = moved->world(index);
    EXPECT_NEAR(q.x, -2 * p.y + 0.5 * p.z + 7, 1e-9);
    EXPECT_NEAR(q.y, p.x + 8, 1e-9);
    EXPECT_NEAR(q.z, 0.25 * p.y + 3 * p.z + 9, 1e-9);
  }
  AffineTransform flat = transform;
  flat[0] = flat[4] = flat[8] = 0;
  EXPECT_FALSE(transformed(grid, flat));
  AffineTransform huge = transform;
  huge[0] = 1e300;
  huge[1] = 1e300;
  EXPECT_FALSE(transformed(grid, huge));
}

BundleStore store_entry(const std::string& path, uint64_t bytes) {
  BundleStore store;
  store.path = path;
  store.file_bytes = bytes;
  store.header_bytes = 100;
  store.bootstrap_offset = 160;
  store.bootstrap_bytes = bytes / 4;
  for (size_t i = 0; i < 16; ++i) store.content_id[i] = static_cast<uint8_t>(i + bytes);
  return store;
}

BundleHeader sample_bundle() {
  return *plan_bundle(scene_of(R"([{"store":"a"},{"store":"b/c"}])"),
                      {store_entry("a", 400), store_entry("b/c", 1000)});
}

TEST(Bundle, PiecesCoverStoresAndBundleOnce) {
  const BundleHeader header = sample_bundle();
  std::vector<BundlePiece> all;
  for (const BundleStore& store : header.stores) {
    uint64_t at = 0;
    for (const BundlePiece& piece : store.pieces()) {
      EXPECT_EQ(piece.store_offset, at);
      at += piece.bytes;
      all.push_back(piece);
    }
    EXPECT_EQ(at, store.file_bytes);
  }
  std::sort(all.begin(), all.end(), [](const BundlePiece& a, const BundlePiece& b) {
    return a.bundle_offset < b.bundle_offset;
  });
  uint64_t at = header.header_bytes;
  for (const BundlePiece& piece : all) {
    EXPECT_EQ(piece.bundle_offset, at);
    at += piece.bytes;
  }
  EXPECT_EQ(at, header.file_bytes);
  EXPECT_EQ(header.stores[1].fine_offset,
            header.header_bytes + header.coarse_bytes + 400 - header.stores[0].coarse_bytes());
}

TEST(Bundle, AHeaderReadsAsItWasWritten) {
  const BundleHeader header = sample_bundle();
  const auto bytes = encode_bundle_header(header);
  EXPECT_EQ(bytes.size(), header.header_bytes);
  EXPECT_TRUE(is_bundle(bytes));
  EXPECT_EQ(bundle_header_bytes(std::span(bytes).first(kBundlePrefixBytes)).value(), bytes.size());
  const auto parsed = parse_bundle_header(bytes);
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_EQ(parsed->scene, header.scene);
  EXPECT_EQ(parsed->file_bytes, header.file_bytes);
  ASSERT_EQ(parsed->stores.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(parsed->stores[i].path, header.stores[i].path);
    EXPECT_EQ(parsed->stores[i].coarse_offset, header.stores[i].coarse_offset);
    EXPECT_EQ(parsed->stores[i].fine_offset, header.stores[i].fine_offset);
    EXPECT_EQ(parsed->stores[i].content_id, header.stores[i].content_id);
  }
}

/// Changes every field, and corrects the checksum. The result must be a defined error, or a header
/// with consistent ranges.
TEST(Bundle, HostileHeadersAreRefused) {
  const auto valid = encode_bundle_header(sample_bundle());
  std::mt19937_64 random(5);
  int refused = 0;
  constexpr int kCases = 3000;
  for (int i = 0; i < kCases; ++i) {
    auto bytes = valid;
    for (int edits = 1 + i % 3; edits > 0; --edits) {
      const size_t at = 8 + random() % (bytes.size() - 16);
      switch (random() % 3) {
        case 0:
          bytes[at] = static_cast<std::byte>(random());
          break;
        case 1:
          write_le(bytes.data() + at / 8 * 8, 8, random());
          break;
        default:
          write_le(bytes.data() + at / 4 * 4, 4, 0xffffffff);
      }
    }
    write_le(bytes.data() + bytes.size() - 8, 8,
             checksum64(std::span(bytes).first(bytes.size() - 8)));
    const auto parsed = parse_bundle_header(bytes);
    if (!parsed) {
      ++refused;
      EXPECT_TRUE(parsed.error().message.starts_with("bundle: ")) << parsed.error().message;
      continue;
    }
    for (const BundleStore& store : parsed->stores) {
      EXPECT_TRUE(is_path_below(store.path));
      for (const BundlePiece& piece : store.pieces()) {
        EXPECT_LE(piece.bundle_offset + piece.bytes, parsed->file_bytes);
      }
    }
  }
  EXPECT_GT(refused, kCases / 2);
  for (size_t bytes = 0; bytes < valid.size(); ++bytes) {
    EXPECT_FALSE(parse_bundle_header(std::span(valid).first(bytes)));
  }
  auto other = valid;
  other.back() ^= std::byte{1};
  EXPECT_EQ(parse_bundle_header(other).error().status, Status::checksum_mismatch);
  const auto with_path = [](const std::string& path) {
    return parse_bundle_header(encode_bundle_header(*plan_bundle("{}", {store_entry(path, 400)})));
  };
  EXPECT_TRUE(with_path("a/b"));
  for (const char* path : {"../a", "/etc/passwd", "scene.json", "a/../../b", ""}) {
    EXPECT_FALSE(with_path(path)) << path;
  }
  EXPECT_FALSE(parse_bundle_header(
      encode_bundle_header(*plan_bundle("{}", {store_entry("a", 400), store_entry("a", 500)}))));
}

}  // namespace
}  // namespace isosplat
