// Tests without a browser that a complete view is correct. The program fetches from a store what a
// view needs, as web/stream does on a slow GPU, whose fast pictures consist of quads. It compares
// the picture with that of all samples of level 0. It prints a line for each camera: the figures
// that truth.bench.ts measures for the page, and the bytes of the chunks. "shown" are the bytes of
// the chunks of level 0 that are visible in the picture, which is the least that could be fetched.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <random>
#include <set>
#include <string>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "native/headless/store_scene.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/select/selector.h"
#include "shared/system/store_file/store_file.h"
#include "tests/bench/need.h"

namespace isosplat {
namespace {

constexpr int kWidth = 944, kHeight = 748;
constexpr uint64_t kCoarseBytes = 160 * 1024;

/// The occlusion queries of a view and their repetition, as in web/stream/occlusion_queries.ts.
struct Step {
  render::SplatKind kind;
  int min_px;
};
constexpr std::array<Step, 3> kSteps = {Step{render::SplatKind::quad, 255},
                                        {render::SplatKind::quad, 0},
                                        {render::SplatKind::exact, 0}};
constexpr uint64_t kManyBytes = 256 * 1024;

struct Difference {
  int covered = 0, differing = 0, stray = 0, lost = 0;
};

bool is_covered(const Image& image, int x, int y) {
  const uint8_t* p = image.at(x, y);
  return 3 * 255 - p[0] - p[1] - p[2] > 12;
}
bool is_near_covered(const Image& image, int x, int y) {
  for (int v = std::max(0, y - 1); v <= std::min(image.height - 1, y + 1); ++v) {
    for (int u = std::max(0, x - 1); u <= std::min(image.width - 1, x + 1); ++u) {
      if (is_covered(image, u, v)) return true;
    }
  }
  return false;
}

Difference compare(const Image& ours, const Image& truth) {
  Difference d;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      int sum = 0;
      for (int c = 0; c < 3; ++c) sum += std::abs(ours.at(x, y)[c] - truth.at(x, y)[c]);
      d.differing += sum > 60;
      const bool covered = is_covered(truth, x, y);
      d.covered += covered;
      d.stray += is_covered(ours, x, y) && !is_near_covered(truth, x, y);
      d.lost += covered && !is_near_covered(ours, x, y);
    }
  }
  return d;
}

render::RenderSettings settings_of(double isovalue) {
  render::RenderSettings settings;
  settings.kind = render::SplatKind::exact;
  settings.isosurfaces = {{isovalue, {0.85f, 0.8f, 0.7f}, 1}};
  settings.background = {1, 1, 1, 1};
  return settings;
}

/// The chunks that a visitor to one view fetches.
class Visit {
 public:
  Visit(const StoreFile& file, render::Renderer& renderer, const render::Camera& camera,
        double isovalue)
      : file_(file),
        renderer_(renderer),
        store_(need(StoreReader::open(file.header()))),
        selector_(store_) {
    const StoreInfo& info = file.info();
    renderer.set_volume(info.grid, info.mapping);
    renderer.set_settings(settings_of(isovalue));
    renderer.set_camera(camera);
    view_.view_projection =
        projection(camera, render::bounding_sphere(info.grid), {0, 0, 0}, kWidth, kHeight)
            .clip_from_world;
    view_.width_px = kWidth;
    view_.height_px = kHeight;
    view_.quantized_isovalues = {info.mapping.quantized_isovalue(isovalue)};
    view_.occlusion = true;
    const CoarseRange coarse = store_.coarse_range(kCoarseBytes);
    for (uint32_t l = coarse.first_level; l < info.levels; ++l) {
      for (const uint32_t index : store_.missing_pages(l, 0, 65535)) page(index);
    }
    for (uint32_t l = coarse.first_level; l < info.levels; ++l) {
      for (const ChunkRef& chunk : need(store_.chunks_for(l, 0, 65535))) {
        load(selector_.handle_of(chunk));
      }
    }
  }

  void run() {
    for (size_t step = 0, turns = 0; turns < 400; ++turns) {
      Selection selection = need(selector_.select(view_));
      if (fetch(selection) > 0) continue;
      show(selection, kSteps[step].kind);
      ++tests;
      need(selector_.set_visibility(ask(selection, kSteps[step].min_px)));
      const bool is_last = step + 1 == kSteps.size();
      uint64_t found = 0;
      for (;;) {
        selection = need(selector_.select(view_));
        const uint64_t fetched = fetch(selection);
        if (fetched == 0) break;
        found += fetched;
      }
      if (selection.undecided > 0) continue;
      if (is_last && found == 0) return;
      if (!is_last && (step == 0 || found <= kManyBytes)) ++step;
    }
    fmt::print("does not end\n");
  }

  Image picture() { return need(draw_image(renderer_, kWidth, kHeight, nullptr, true)); }

  uint64_t bytes_shown() {
    const Selection selection = need(selector_.select(view_));
    show(selection, render::SplatKind::exact);
    std::vector<ChunkHandle> handles;
    for (const DrawnChunk& drawn : selection.draw) handles.push_back(drawn.handle);
    uint64_t sum = 0;
    for (size_t i = 0; i < handles.size(); i += 1000) {
      const size_t count = std::min<size_t>(1000, handles.size() - i);
      need(renderer_.begin_occlusion_query(std::span(handles).subspan(i, count), 1));
      for (const ChunkVisibility& visibility : answer()) {
        if (visibility.visible.any()) sum += need(selector_.chunk(visibility.handle)).bytes;
      }
    }
    return sum;
  }

  std::map<uint32_t, uint64_t> bytes;  ///< by level
  int tests = 0;

 private:
  uint64_t page(uint32_t index) {
    if (store_.is_resident(index)) return 0;
    const auto encoded = need(file_.read_page(index));
    need(store_.add_page(index, encoded));
    return encoded.size();
  }

  uint64_t load(ChunkHandle handle) {
    const ChunkRef chunk = need(selector_.chunk(handle));
    std::vector<std::byte> encoded;
    need(file_.read_chunk(chunk, encoded));
    const LevelGrid grid = level_grid(file_.info().grid.voxels, chunk.block.level);
    const ChunkShape shape{block_cells(grid, chunk.block.index), chunk.band_begin, chunk.band_end,
                           chunk.cells, chunk.block.level > 0};
    std::vector<PackedSample> samples;
    need(decoder_.decode_packed(encoded, shape, samples));
    need(renderer_.add_chunk(handle, chunk.block, samples));
    need(selector_.set_resident(handle, true));
    bytes[chunk.block.level] += chunk.bytes;
    return chunk.bytes;
  }

  /// Fetches the chunks of a selection. Returns their bytes.
  uint64_t fetch(const Selection& selection) {
    uint64_t sum = 0;
    for (const uint32_t index : selection.pages) sum += page(index);
    for (const ChunkHandle handle : selection.load) sum += load(handle);
    return sum;
  }

  void show(const Selection& selection, render::SplatKind kind) {
    renderer_.set_visible(std::span<const DrawnChunk>(selection.draw));
    render::RenderSettings settings = renderer_.settings();
    settings.kind = kind;
    renderer_.set_settings(settings);
    if (renderer_.needs_redraw(kWidth, kHeight)) need(draw_image(renderer_, kWidth, kHeight));
  }

  std::vector<ChunkVisibility> answer() {
    for (;;) {
      if (auto taken = renderer_.take_occlusion_query()) return *taken;
    }
  }

  std::vector<ChunkVisibility> ask(const Selection& selection, int min_px) {
    if (selection.test.empty()) return {};
    need(renderer_.begin_occlusion_query(selection.test, min_px));
    return answer();
  }

  const StoreFile& file_;
  render::Renderer& renderer_;
  StoreReader store_;
  Selector selector_;
  ChunkDecoder decoder_;
  SelectionView view_;
};

render::Camera parse_camera(const std::string& text) {
  std::vector<double> c;
  for (size_t at = 0; at <= text.size();) {
    const size_t end = std::min(text.find(',', at), text.size());
    c.push_back(std::atof(text.substr(at, end - at).c_str()));
    at = end + 1;
  }
  return {{c.at(3), c.at(4), c.at(5)}, c[2], c[0], c[1], 0, 30};
}

int run(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr, "usage: isosplat_complete_view STORE ISOVALUE CAMERA...\n");
    return 2;
  }
  const auto file = need(StoreFile::open(argv[1]));
  const double isovalue = std::atof(argv[2]);
  const auto context = need(EglContext::create());
  const auto renderer = need(render::Renderer::create());
  int wrong = 0;
  for (int i = 3; i < argc; ++i) {
    const render::Camera camera = parse_camera(argv[i]);
    Visit visit(*file, *renderer, camera, isovalue);
    visit.run();
    const Image ours = visit.picture();
    const uint64_t shown = visit.bytes_shown();
    std::string levels;
    uint64_t sum = 0;
    for (const auto& [level, bytes] : visit.bytes) {
      levels += fmt::format(" {}:{}", level, bytes / 1000);
      sum += bytes;
    }
    const std::vector<double> isovalues{isovalue};
    need(show_store(*renderer, *file, isovalues, 0, UINT64_MAX));
    const Image truth = need(draw_image(*renderer, kWidth, kHeight, nullptr, true));
    const Difference d = compare(ours, truth);
    fmt::print(
        "{} {}: covered {} differing {} stray {} lost {}; {} KB (shown {}), by level{}; {} tests\n",
        argv[2], argv[i], d.covered, d.differing, d.stray, d.lost, sum / 1000, shown / 1000, levels,
        visit.tests);
    std::fflush(stdout);
    wrong += d.stray > 0 || d.differing > d.covered / 10000;
  }
  return wrong > 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
