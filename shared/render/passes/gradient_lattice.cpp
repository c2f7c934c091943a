#include "shared/render/passes/gradient_lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "shared/render/passes/image_triangle.h"
#include "shared/render/passes/triangle_cases.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

constexpr uint32_t kLeastPages = 1024, kMostPages = 8192;
constexpr int32_t kMaxTableSide = 256;  // every WebGL 2 context has 3D textures of this size
constexpr int32_t kMaxTableSize = 1 << 20;

Index3 first_region(const BlockKey& block) {
  return {block.index.x * kBlockRegions, block.index.y * kBlockRegions,
          block.index.z * kBlockRegions};
}

/// The first and the last region with corners of the cluster's cells.
struct RegionRange {
  Index3 low, high;
};
RegionRange regions_of(const BlockKey& block, const SampleCluster& cluster) {
  constexpr int32_t kCells = kBlockCells / kBlockRegions;
  const Index3 first = first_region(block);
  const auto along = [](int32_t from, uint8_t cell) { return from + cell / kCells; };
  return {
      {along(first.x, cluster.low.x), along(first.y, cluster.low.y), along(first.z, cluster.low.z)},
      {along(first.x, cluster.high.x), along(first.y, cluster.high.y),
       along(first.z, cluster.high.z)}};
}

/// Whether smooth normals are visible in this chunk.
bool is_shown(const DrawItem& item, const DrawList& list, float quantized_isovalue,
              SmoothSizes sizes) {
  return item.chunk->block.level == list.finest_level() && item.largest_side_px > sizes.from_px &&
         is_active(item.chunk->interval, quantized_isovalue);
}

/// The chunks that contribute to the gradients around an isosurface, in view or not.
std::vector<LatticeChunk> contributors(const ChunkStore& chunks, uint32_t level,
                                       float quantized_isovalue) {
  std::vector<LatticeChunk> result;
  for (const DrawnChunk& visible : chunks.visible()) {
    const ChunkStore::Chunk* chunk = chunks.find(visible.handle);
    if (!chunk || chunk->block.level != level || !is_active(chunk->interval, quantized_isovalue)) {
      continue;
    }
    result.push_back({chunk->range.serial, first_region(chunk->block), visible.regions});
  }
  return result;
}

/// Marks the regions around the surface in view. Returns false if they do not fit into a table.
bool mark_needed(const GradientLattice::Source& source, float quantized_isovalue, SmoothSizes sizes,
                 LatticeRegions& regions) {
  constexpr int32_t kMost = std::numeric_limits<int32_t>::max();
  Index3 low{kMost, kMost, kMost}, high{0, 0, 0};
  for (const DrawItem& item : source.list.items()) {
    if (!is_shown(item, source.list, quantized_isovalue, sizes)) continue;
    const Index3 first = first_region(item.chunk->block);
    low = {std::min(low.x, first.x), std::min(low.y, first.y), std::min(low.z, first.z)};
    high = {std::max(high.x, first.x + kBlockRegions), std::max(high.y, first.y + kBlockRegions),
            std::max(high.z, first.z + kBlockRegions)};
  }
  if (low.x == kMost) low = high;  // none is shown
  const Index3 size{high.x - low.x + 1, high.y - low.y + 1, high.z - low.z + 1};
  if (std::max({size.x, size.y, size.z}) > kMaxTableSide ||
      int64_t{size.x} * size.y * size.z > kMaxTableSize) {
    return false;
  }
  regions.begin(low, size);
  source.list.find_active(source.frame, quantized_isovalue);
  for (const DrawItem& item : source.list.items()) {
    if (!is_shown(item, source.list, quantized_isovalue, sizes)) continue;
    source.list.for_each_cluster(item, [&](const SampleCluster& cluster) {
      const auto [from, to] = regions_of(item.chunk->block, cluster);
      regions.need(from, to);
    });
  }
  return true;
}

}  // namespace

bool GradientLattice::has_one_level(const DrawList& list, SmoothSizes sizes) {
  const uint32_t finest = list.finest_level();
  return std::all_of(list.items().begin(), list.items().end(), [&](const DrawItem& item) {
    return item.chunk->block.level == finest || !has_smooth_normals(item, finest, sizes);
  });
}

Result<std::vector<int>> GradientLattice::replace_normals(const DrawContext& context,
                                                          const Source& source,
                                                          std::span<const int> isosurfaces,
                                                          int layer, SmoothSizes sizes,
                                                          SampleTexture& samples) {
  if (!has_one_level(source.list, sizes))
    return std::vector<int>(isosurfaces.begin(), isosurfaces.end());
  std::vector<int> others;
  bool any = false;
  for (const int isosurface : isosurfaces) {
    const auto updated = update(context, source, isosurface, sizes, samples);
    if (!updated) return tl::unexpected(updated.error());
    if (!*updated) {
      others.push_back(isosurface);
      continue;
    }
    if (!any) {
      if (auto ok = clear_normals(context); !ok) return tl::unexpected(ok.error());
      any = true;
    }
    if (auto ok = add_normals(context, source, isosurface, layer, sizes); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  if (any) {
    if (auto ok = copy_normals(context, layer); !ok) return tl::unexpected(ok.error());
  }
  return others;
}

bool GradientLattice::has_triangles(const DrawContext& context, const DrawList& list) {
  const auto is_triangles = [&](const DrawItem& item) {
    return is_drawn_as_triangles(item, context.settings);
  };
  return context.limits.offered.float_targets &&
         std::any_of(list.items().begin(), list.items().end(), is_triangles);
}

Result<bool> GradientLattice::prepare_triangles(const DrawContext& context, const Source& source,
                                                int isosurface, SampleTexture& samples) {
  if (!has_triangles(context, source.list)) return false;
  constexpr SmoothSizes kTriangles{float(TRIANGLE_SIDE_PX), float(TRIANGLE_SIDE_PX)};
  const auto updated = update(context, source, isosurface, kTriangles, samples);
  if (!updated || !*updated) return updated;
  bind_texture(6, GL_TEXTURE_2D, gradients_.texture());
  bind_texture(5, GL_TEXTURE_3D, table_);
  return true;
}

void GradientLattice::set_block(const GlProgram& program, int isosurface,
                                const BlockKey& block) const {
  const Index3 low = surfaces_[static_cast<size_t>(isosurface)].low(), first = first_region(block);
  glUniform3i(program.uniform("u_first_region"), first.x - low.x, first.y - low.y, first.z - low.z);
}

/// Computes the gradients around an isosurface that are not known yet. Returns false if it has
/// none.
Result<bool> GradientLattice::update(const DrawContext& context, const Source& source,
                                     int isosurface, SmoothSizes sizes, SampleTexture& samples) {
  const uint32_t level = source.list.finest_level();
  const auto index = static_cast<size_t>(isosurface);
  const float quantized_isovalue =
      source.mapping.quantized_isovalue(context.settings.isosurfaces[index].isovalue);
  const size_t count = context.settings.isosurfaces.size();
  for (size_t i = count; i < surfaces_.size(); ++i) surfaces_[i].clear(free_);
  surfaces_.resize(count);
  LatticeRegions& regions = surfaces_[index];
  regions.set_chunks(level, contributors(source.chunks, level, quantized_isovalue), free_);
  if (!mark_needed(source, quantized_isovalue, sizes, regions) || !assign_pages(context, regions)) {
    regions.clear(free_);
    return false;
  }
  upload_table(regions);
  if (regions.new_pages().empty()) return true;
  bind_texture(6, GL_TEXTURE_2D, 0);  // may not be bound while it is drawn into
  if (auto ok = fill_pages(context, source, quantized_isovalue, regions, samples); !ok) {
    regions.clear(free_);
    return tl::unexpected(ok.error());
  }
  return true;
}

/// Gives pages to the needed regions: those that other isosurfaces do not need, or in a larger
/// texture. Returns false if they do not fit into the largest one, or into the GPU's memory.
bool GradientLattice::assign_pages(const DrawContext& context, LatticeRegions& regions) {
  if (regions.assign(free_)) return true;
  for (size_t i = 0; i < surfaces_.size(); ++i) {
    if (&surfaces_[i] == &regions) continue;
    const bool is_drawn = context.settings.isosurfaces[i].opacity > 0;
    is_drawn ? surfaces_[i].drop_unneeded(free_) : surfaces_[i].clear(free_);
  }
  if (regions.assign(free_)) return true;
  const auto needed = static_cast<uint32_t>(std::min<size_t>(regions.needed(), kMostPages));
  if (needed >= kMostPages || capacity_ == kMostPages || has_no_memory_) return false;
  const uint32_t pages = std::max({kLeastPages, 2 * capacity_, std::bit_ceil(needed + 1)});
  has_no_memory_ = !set_capacity(pages);
  return !has_no_memory_ && regions.assign(free_);
}

/// All pages become free.
Result<void> GradientLattice::set_capacity(uint32_t pages) {
  for (LatticeRegions& regions : surfaces_) regions.clear(free_);
  free_.clear();
  capacity_ = 0;
  const auto rows = static_cast<int>(pages / LATTICE_COLUMNS);
  const auto prepared =
      gradients_.prepare(LATTICE_COLUMNS * LATTICE_PAGE_WIDTH, rows * LATTICE_PAGE_HEIGHT);
  if (!prepared) return prepared;
  capacity_ = pages;
  for (uint32_t page = pages; --page > 0;) free_.push_back(page);
  const uint32_t zero_page = 0;
  clear_pages({&zero_page, 1});
  return {};
}

/// Clears pages, in ascending order. Leaves the framebuffer bound.
void GradientLattice::clear_pages(std::span<const uint32_t> pages) const {
  glBindFramebuffer(GL_FRAMEBUFFER, gradients_.framebuffer());
  glEnable(GL_SCISSOR_TEST);
  const float zero[4] = {0, 0, 0, 0};
  for (size_t i = 0; i < pages.size();) {
    const uint32_t column = pages[i] % LATTICE_COLUMNS, row = pages[i] / LATTICE_COLUMNS;
    uint32_t count = 1;  // of successive pages in this row
    while (i + count < pages.size() && column + count < LATTICE_COLUMNS &&
           pages[i + count] == pages[i] + count) {
      ++count;
    }
    glScissor(static_cast<GLint>(column * LATTICE_PAGE_WIDTH),
              static_cast<GLint>(row * LATTICE_PAGE_HEIGHT),
              static_cast<GLsizei>(count * LATTICE_PAGE_WIDTH), LATTICE_PAGE_HEIGHT);
    glClearBufferfv(GL_COLOR, 0, zero);
    i += count;
  }
  glDisable(GL_SCISSOR_TEST);
}

void GradientLattice::upload_table(const LatticeRegions& regions) {
  const Index3 size = regions.size();
  if (table_ && size == table_size_ && regions.table() == uploaded_) return;
  if (!table_ || size != table_size_) {
    if (table_) glDeleteTextures(1, &table_);
    glGenTextures(1, &table_);
    bind_texture(2, GL_TEXTURE_3D, table_);
    glTexStorage3D(GL_TEXTURE_3D, 1, GL_R32UI, size.x, size.y, size.z);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    table_size_ = size;
  }
  bind_texture(2, GL_TEXTURE_3D, table_);
  glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, size.x, size.y, size.z, GL_RED_INTEGER,
                  GL_UNSIGNED_INT, regions.table().data());
  uploaded_ = regions.table();
}

/// Sums the gradients of all cells around the regions with new pages.
Result<void> GradientLattice::fill_pages(const DrawContext& context, const Source& source,
                                         float quantized_isovalue, const LatticeRegions& regions,
                                         SampleTexture& samples) {
  const auto program = context.programs.splat({.pass = SplatPass::lattice, .pulled = true});
  if (!program) return tl::unexpected(program.error());
  const GlProgram& gl = (*program)->program;
  clear_pages(regions.new_pages());
  glUseProgram(gl.name());
  glViewport(0, 0, gradients_.width(), gradients_.height());
  glUniform2f(gl.uniform("u_texture_size"), static_cast<float>(gradients_.width()),
              static_cast<float>(gradients_.height()));
  const GLint first_uniform = gl.uniform("u_first_region");
  bind_texture(2, GL_TEXTURE_3D, table_);
  glBindVertexArray(context.empty_vertex_array);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE);
  const uint32_t level = source.list.finest_level();
  for (const DrawnChunk& visible : source.chunks.visible()) {
    const ChunkStore::Chunk* chunk = source.chunks.find(visible.handle);
    if (!chunk || chunk->block.level != level || !is_active(chunk->interval, quantized_isovalue)) {
      continue;
    }
    bool any = false;
    for (const SampleCluster& cluster : chunk->clusters) {
      const auto [from, to] = regions_of(chunk->block, cluster);
      if (!visible.regions.contains(cluster.region_index()) || !regions.has_new(from, to)) continue;
      constexpr uint32_t kCorners = 8;
      runs_.add(kCorners * cluster.first, kCorners * cluster.count);
      any = true;
    }
    if (!any) continue;
    samples.load(source.chunks.buffers(), chunk->range);
    const Index3 first = first_region(chunk->block), low = regions.low();
    glUniform3i(first_uniform, first.x - low.x, first.y - low.y, first.z - low.z);
    context.statistics.draw_calls += runs_.draw(GL_POINTS, context.limits.multi_draw);
  }
  glDisable(GL_BLEND);
  glEnable(GL_DEPTH_TEST);
  return {};
}

Result<void> GradientLattice::clear_normals(const DrawContext& context) {
  const SurfaceTargets& targets = context.targets;
  if (auto ok = normals_.prepare(targets.width(), targets.height()); !ok) return ok;
  glBindFramebuffer(GL_FRAMEBUFFER, normals_.framebuffer());
  const GLuint zero[4] = {0, 0, 0, 0};
  glClearBufferuiv(GL_COLOR, 0, zero);
  return {};
}

/// Computes the normals of the layer's pixels that show the isosurface of the last update().
Result<void> GradientLattice::add_normals(const DrawContext& context, const Source& source,
                                          int isosurface, int layer, SmoothSizes sizes) {
  const auto linked = context.programs.image(ImagePass::lattice_normals);
  if (!linked) return tl::unexpected(linked.error());
  const GlProgram& program = **linked;
  const Frame& frame = source.frame;
  const LatticeRegions& regions = surfaces_[static_cast<size_t>(isosurface)];
  const auto level = static_cast<int>(source.list.finest_level());
  const double cell = std::ldexp(1.0, level);
  const Index3 low = regions.low();
  const Vec3d corner =
      Vec3d{double(low.x), double(low.y), double(low.z)} * (cell * kBlockCells / kBlockRegions);
  const Vec3d at = frame.box(corner, corner).centre;
  const auto& edges = frame.block().cell_edges;
  const auto scale = static_cast<float>(cell);
  glBindFramebuffer(GL_FRAMEBUFFER, normals_.framebuffer());
  glViewport(0, 0, normals_.width(), normals_.height());
  glUseProgram(program.name());
  glUniform1i(program.uniform("u_layer"), layer);
  glUniform1ui(program.uniform("u_isosurface"), static_cast<GLuint>(isosurface));
  glUniform3f(program.uniform("u_lattice_low"), static_cast<float>(at.x), static_cast<float>(at.y),
              static_cast<float>(at.z));
  glUniform3f(program.uniform("u_per_cell"), 1 / (edges[0] * scale), 1 / (edges[1] * scale),
              1 / (edges[2] * scale));
  glUniform1f(program.uniform("u_side_px"),
              static_cast<float>(cell * frame.cell_side()) * frame.block().focal_px);
  glUniform2f(program.uniform("u_smooth_px"), sizes.from_px, 1 / (sizes.full_px - sizes.from_px));
  bind_texture(3, GL_TEXTURE_2D, gradients_.texture());
  bind_texture(2, GL_TEXTURE_3D, table_);
  bind_texture(1, GL_TEXTURE_2D_ARRAY, context.targets.depths());
  bind_texture(0, GL_TEXTURE_2D_ARRAY, context.targets.surfaces());
  glDisable(GL_DEPTH_TEST);
  draw_image_triangle(context);
  glEnable(GL_DEPTH_TEST);
  // Textures that are drawn into may not be bound.
  bind_texture(3, GL_TEXTURE_2D, 0);
  bind_texture(1, GL_TEXTURE_2D_ARRAY, 0);
  bind_texture(0, GL_TEXTURE_2D_ARRAY, 0);
  return {};
}

/// Replaces the normals of the layer's pixels by those that were added.
Result<void> GradientLattice::copy_normals(const DrawContext& context, int layer) {
  const auto program = context.programs.image(ImagePass::replace_normals);
  if (!program) return tl::unexpected(program.error());
  const SurfaceTargets& targets = context.targets;
  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer_framebuffer(layer));
  glViewport(0, 0, targets.width(), targets.height());
  glUseProgram((*program)->name());
  bind_texture(0, GL_TEXTURE_2D, normals_.texture());
  glDisable(GL_DEPTH_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_FALSE, GL_FALSE);  // the two components of the normal
  draw_image_triangle(context);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glEnable(GL_DEPTH_TEST);
  bind_texture(0, GL_TEXTURE_2D, 0);
  return {};
}

uint64_t GradientLattice::bytes() const {
  return gradients_.bytes() + normals_.bytes() + (table_ ? 4 * uploaded_.size() : 0);
}

GradientLattice::~GradientLattice() {
  if (table_) glDeleteTextures(1, &table_);
}

void GradientLattice::abandon() {
  gradients_.abandon();
  normals_.abandon();
  surfaces_.clear();
  free_.clear();
  capacity_ = 0;
  has_no_memory_ = false;
  table_ = 0;
  table_size_ = {0, 0, 0};
  uploaded_.clear();
}

}  // namespace isosplat::render
