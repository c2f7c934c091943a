// The picture that isosplat build draws beside a store.

#include <webp/decode.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "native/headless/image.h"
#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::read_file;
using test::TempFolder;
using test::write_ball;
using test::write_file;

Ended run(std::vector<std::string> arguments) {
  return test::run(test::Call{.arguments = std::move(arguments), .draws_thumbnails = true});
}

/// The content id in the chunk that follows VP8X.
std::string content_of(const std::string& webp) {
  constexpr size_t kContentChunk = 30;
  if (webp.substr(0, 4) != "RIFF" || webp.substr(kContentChunk, 4) != "ISOS") return {};
  return webp.substr(kContentChunk + 8, 32);
}

/// Decodes a WebP file; empty if it is none.
Image read_webp(const std::string& bytes) {
  Image image;
  uint8_t* const pixels = WebPDecodeRGBA(reinterpret_cast<const uint8_t*>(bytes.data()),
                                         bytes.size(), &image.width, &image.height);
  if (!pixels) return {};
  image.rgba.assign(pixels, pixels + 4 * image.width * image.height);
  WebPFree(pixels);
  return image;
}

/// Sets an environment variable (null: removes it) during the lifetime of the object.
class TemporaryVariable {
 public:
  TemporaryVariable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    set(value);
  }
  ~TemporaryVariable() { set(before_ ? before_->c_str() : nullptr); }
  TemporaryVariable(const TemporaryVariable&) = delete;
  TemporaryVariable& operator=(const TemporaryVariable&) = delete;

 private:
  void set(const char* value) const { value ? setenv(name_, value, 1) : unsetenv(name_); }

  const char* name_;
  std::optional<std::string> before_;
};

class CliThumbnail : public ::testing::Test {
 protected:
  Ended build(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"build", volume, "-o", store};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  std::string store_content() const {
    const std::string json = run({"info", store, "--json"}).out;
    const std::string key = "\"contentId\": \"";
    return json.substr(json.find(key) + key.size(), 32);
  }

  const TempFolder folder;
  const std::string volume = write_ball(folder, 40);
  const std::string store = folder / "ball.isosplat", picture = store + ".webp";
};

TEST_F(CliThumbnail, BuildDrawsThePictureOfTheStore) {
  const Ended built = build();
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_EQ(built.err.find("note: no thumbnail"), std::string::npos) << built.err;
  EXPECT_EQ(content_of(read_file(picture)), store_content());
  EXPECT_GT(read_file(picture).size(), 1000u);
  EXPECT_LT(read_file(picture).size(), 15'000u);
}

TEST_F(CliThumbnail, BuildDrawsThePictureOfAScene) {
  const std::string scene = folder / "run.isobundle", drawn = scene + ".webp";
  const auto build_steps = [&](const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"build", volume, write_ball(folder, 36, "next"), "-o",
                                       scene};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Ended built = run(arguments);
    EXPECT_EQ(built.exit_code, 0) << built.err;
    EXPECT_EQ(built.err.find("note: no thumbnail"), std::string::npos) << built.err;
    return built.out;
  };
  build_steps({"--no-thumbnail"});
  EXPECT_FALSE(std::filesystem::exists(drawn));
  const std::string said = build_steps();
  EXPECT_NE(said.find("isosplat view " + scene + " shows it"), std::string::npos) << said;
  const std::string first = read_file(drawn);
  EXPECT_GT(first.size(), 1000u);
  // The id in the picture is the checksum at the end of the bundle's header, lowest byte first.
  const auto id_of_bundle = [&] {
    const std::string bundle = read_file(scene);
    size_t header = 0;
    for (int i = 3; i >= 0; --i) header = header << 8 | static_cast<uint8_t>(bundle[12 + i]);
    std::string id;
    for (size_t i = 1; i <= 8; ++i) {
      constexpr const char* kDigits = "0123456789abcdef";
      const auto byte = static_cast<uint8_t>(bundle[header - i]);
      id += kDigits[byte >> 4];
      id += kDigits[byte & 15];
    }
    return id;
  };
  EXPECT_EQ(content_of(first).substr(0, 16), id_of_bundle());
  // When the content changes, the picture is drawn again. A picture of the current content that the
  // user has made is kept.
  build_steps({"--time-unit", "s"});
  const std::string second = read_file(drawn);
  EXPECT_EQ(content_of(second).substr(0, 16), id_of_bundle());
  EXPECT_NE(content_of(second), content_of(first));
  ASSERT_EQ(run({"render", scene, "--size", "48x30", "-o", drawn}).exit_code, 0);
  const std::string own = read_file(drawn);
  EXPECT_EQ(content_of(own).substr(0, 16), id_of_bundle());
  build_steps({"--time-unit", "s"});
  EXPECT_EQ(read_file(drawn), own);
}

TEST_F(CliThumbnail, ASmallSurfaceInACornerFillsThePicture) {
  constexpr int kVoxels = 48;
  std::string voxels;
  for (int i = 0; i < kVoxels * kVoxels * kVoxels; ++i) {
    const int x = i % kVoxels - 9, y = i / kVoxels % kVoxels - 9;
    const int z = i / (kVoxels * kVoxels) - 38;
    voxels += static_cast<char>(std::max(0, 120 - 10 * (x * x + y * y + z * z) / 8));
  }
  const std::string raw = folder / "corner.raw";
  write_file(raw, voxels);
  const Ended built = run({"build", raw, "--dims", "48x48x48", "--type", "u8", "-o", store});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const Image image = read_webp(read_file(picture));
  ASSERT_GT(image.width, 0);
  int left = image.width, right = 0, top = image.height, bottom = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, y)[3] < 128) continue;
      left = std::min(left, x), right = std::max(right, x + 1);
      top = std::min(top, y), bottom = std::max(bottom, y + 1);
    }
  }
  EXPECT_NEAR(left + right, image.width, 0.04 * image.width);
  EXPECT_NEAR(top + bottom, image.height, 0.04 * image.height);
  EXPECT_NEAR(bottom - top, 0.88 * image.height, 0.04 * image.height);
}

TEST_F(CliThumbnail, InfoDrawsTheSuggestedIsovalues) {
  ASSERT_EQ(build({"--no-thumbnail"}).exit_code, 0);
  const std::filesystem::path pictures = folder / "pictures";
  std::filesystem::create_directory(pictures);
  const Ended ended = run({"info", store, "--pictures", pictures.string(), "--json"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const auto json = nlohmann::json::parse(ended.out);
  const auto suggested = json["metadata"]["suggested_isovalues"];
  ASSERT_GT(suggested.size(), 0u);
  ASSERT_EQ(json["pictures"].size(), suggested.size());
  for (size_t i = 0; i < suggested.size(); ++i) {
    EXPECT_EQ(json["pictures"][i]["isovalue"], suggested[i]);
    const auto image = read_png(json["pictures"][i]["file"].get<std::string>());
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_FALSE(image->is_uniform());
  }
  EXPECT_NE(run({"info", volume, "--pictures", pictures.string()}).err.find("expected a store"),
            std::string::npos);
}

TEST_F(CliThumbnail, NoThumbnailLeavesItOut) {
  ASSERT_EQ(build({"--no-thumbnail"}).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(picture));
  const TemporaryVariable none("ISOSPLAT_NO_THUMBNAIL", "1");
  ASSERT_EQ(build().exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(picture)) << "the environment applies to all builds";
  const TemporaryVariable some("ISOSPLAT_NO_THUMBNAIL", "0");
  ASSERT_EQ(build().exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(picture));
}

TEST_F(CliThumbnail, KeepsTheUsersPictureUntilTheContentChanges) {
  ASSERT_EQ(build().exit_code, 0);
  ASSERT_EQ(run({"render", store, "--isovalue", "60", "--size", "64x40", "-o", picture}).exit_code,
            0);
  const std::string chosen = read_file(picture);
  EXPECT_EQ(content_of(chosen), store_content());
  ASSERT_EQ(build().exit_code, 0);
  EXPECT_EQ(read_file(picture), chosen);
  write_ball(folder, 44);
  ASSERT_EQ(build().exit_code, 0);
  EXPECT_NE(read_file(picture), chosen);
  EXPECT_EQ(content_of(read_file(picture)), store_content());
}

TEST_F(CliThumbnail, ReplacesAPictureThatWouldNotBeServed) {
  ASSERT_EQ(build().exit_code, 0);
  const std::string good = read_file(picture);
  write_file(picture, good.substr(0, good.size() / 2));
  ASSERT_EQ(build().exit_code, 0);
  EXPECT_EQ(read_file(picture), good);

  const Ended drawn =
      run({"render", store, "--isovalue", "60", "--size", "2050x16", "--aliased", "-o", picture});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_NE(drawn.err.find("too large for a thumbnail"), std::string::npos) << drawn.err;
  ASSERT_EQ(build().exit_code, 0);
  EXPECT_EQ(read_file(picture), good);
}

TEST_F(CliThumbnail, DoesNotNoteTheSizeOfOtherPictures) {
  ASSERT_EQ(build().exit_code, 0);
  const Ended drawn = run({"render", store, "--isovalue", "60", "--size", "2050x16", "--aliased",
                           "-o", folder / "wide.png"});
  EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_EQ(drawn.err.find("too large"), std::string::npos) << drawn.err;
}

// Mesa writes a warning if it cannot make a folder for its cache of shaders.
TEST_F(CliThumbnail, BuildIsQuietWithoutAFolderForCaches) {
  const std::string missing = folder / "none/cache";
  const TemporaryVariable mesa("MESA_SHADER_CACHE_DIR", nullptr);
  for (const char* cache : {missing.c_str(), "", static_cast<const char*>(nullptr)}) {
    const TemporaryVariable xdg("XDG_CACHE_HOME", cache), home("HOME", cache);
    std::filesystem::remove(picture);
    const Ended built = build();
    EXPECT_EQ(built.exit_code, 0) << built.err;
    EXPECT_EQ(built.err.find("shader cache"), std::string::npos) << built.err;
    EXPECT_TRUE(std::filesystem::exists(picture));
  }
}

TEST_F(CliThumbnail, NeverReplacesAnotherFile) {
  write_file(picture, "a holiday picture");
  const Ended built = build();
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find("note: no thumbnail: "), std::string::npos) << built.err;
  EXPECT_EQ(read_file(picture), "a holiday picture");
}

TEST_F(CliThumbnail, BuildSucceedsWithoutOpenGl) {
  // libglvnd then finds no driver.
  setenv("__EGL_VENDOR_LIBRARY_DIRS", folder.path().c_str(), 1);
  setenv("__EGL_VENDOR_LIBRARY_FILENAMES", (folder / "none.json").c_str(), 1);
  const Ended built = build();
  unsetenv("__EGL_VENDOR_LIBRARY_DIRS");
  unsetenv("__EGL_VENDOR_LIBRARY_FILENAMES");
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find("note: no thumbnail: EGL offers no display"), std::string::npos)
      << built.err;
  EXPECT_FALSE(std::filesystem::exists(picture));
  EXPECT_EQ(run({"verify", store}).exit_code, 0);
}

}  // namespace
}  // namespace isosplat
