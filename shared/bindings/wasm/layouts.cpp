#include "shared/bindings/wasm/layouts.h"

#include <algorithm>
#include <type_traits>

#include "shared/bindings/wasm/core_api.h"
#include "shared/core/grid/region_mask.h"
#include "shared/core/include/isosplat/store.h"
#include "shared/core/sampling/packed_sample.h"
#include "shared/render/settings/colour_maps.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::layouts {
namespace {

using namespace isosplat::render;

template <class T>
constexpr const char* type_name() {
  if constexpr (std::is_same_v<T, double>) return "Float64";
  if constexpr (std::is_same_v<T, float>) return "Float32";
  if constexpr (std::is_same_v<T, int32_t>) return "Int32";
  if constexpr (std::is_same_v<T, uint32_t>) return "Uint32";
  if constexpr (std::is_same_v<T, uint8_t>) return "Uint8";
}

template <class T>
Field field(const char* name, size_t offset) {
  using Element = std::remove_extent_t<T>;
  return {name, type_name<Element>(), offset, sizeof(Element), std::extent_v<T>};
}

#define FIELD(member) field<decltype(R::member)>(#member, offsetof(R, member))
#define RECORD(name, filled, ...)                                   \
  [] {                                                              \
    using R = Isosplat##name;                                       \
    static_assert(std::is_standard_layout_v<R>);                    \
    return Record{#name, sizeof(R), Filled::filled, {__VA_ARGS__}}; \
  }()

// The compiler warns of a value that a switch does not handle, and warnings are errors.
const char* name_of(SplatKind kind) {
  switch (kind) {
    case SplatKind::quad:
      return "quad";
    case SplatKind::ellipse:
      return "ellipse";
    case SplatKind::exact:
      return "exact";
  }
  return nullptr;
}

const char* name_of(Shading shading) {
  switch (shading) {
    case Shading::smooth:
      return "smooth";
    case Shading::exact:
      return "exact";
  }
  return nullptr;
}

const char* name_of(ColourBy quantity) {
  switch (quantity) {
    case ColourBy::isosurface:
      return "isosurface";
    case ColourBy::isovalue:
      return "isovalue";
    case ColourBy::gradient:
      return "gradient";
    case ColourBy::depth:
      return "depth";
    case ColourBy::level:
      return "level";
    case ColourBy::projection_error:
      return "projection-error";
    case ColourBy::field:
      return "field";
  }
  return nullptr;
}

const char* name_of(FieldScale scale) {
  switch (scale) {
    case FieldScale::linear:
      return "linear";
    case FieldScale::logarithmic:
      return "logarithmic";
    case FieldScale::symmetric:
      return "symmetric";
  }
  return nullptr;
}

const char* name_of(ColourMap map) {
  switch (map) {
    case ColourMap::viridis:
      return "viridis";
    case ColourMap::magma:
      return "magma";
    case ColourMap::cividis:
      return "cividis";
    case ColourMap::turbo:
      return "turbo";
  }
  return nullptr;
}

/// The names of all values, which must be 0, 1, 2, …
template <class Enum>
std::vector<const char*> names_of() {
  std::vector<const char*> names;
  for (int value = 0; const char* name = name_of(static_cast<Enum>(value)); ++value) {
    names.push_back(name);
  }
  return names;
}

}  // namespace

std::vector<Record> all_records() {
  return {
      RECORD(Chunk, by_cpp, FIELD(offset), FIELD(handle), FIELD(level), FIELD(block), FIELD(band),
             FIELD(band_begin), FIELD(band_end), FIELD(bytes), FIELD(cells), FIELD(checksum),
             FIELD(block_cells)),
      RECORD(ChunkShape, by_javascript, FIELD(block_cells), FIELD(band_begin), FIELD(band_end),
             FIELD(cells), FIELD(level), FIELD(block)),
      RECORD(Block, by_javascript, FIELD(level), FIELD(block)),
      RECORD(Page, by_cpp, FIELD(offset), FIELD(bytes), FIELD(level), FIELD(first_block),
             FIELD(resident), FIELD(interval_min), FIELD(interval_max)),
      RECORD(StoreInfo, by_cpp, FIELD(spacing), FIELD(origin), FIELD(direction),
             FIELD(value_offset), FIELD(value_scale), FIELD(max_error), FIELD(chunk_count),
             FIELD(missing_voxels), FIELD(file_bytes), FIELD(voxels), FIELD(bits),
             FIELD(has_missing), FIELD(min_quantized), FIELD(max_quantized), FIELD(levels),
             FIELD(content_id)),
      RECORD(Field, by_cpp, FIELD(value_offset), FIELD(value_scale), FIELD(max_error),
             FIELD(missing_voxels), FIELD(offset), FIELD(bytes), FIELD(bits), FIELD(has_missing),
             FIELD(min_quantized), FIELD(max_quantized), FIELD(name)),
      RECORD(CoarseRange, by_cpp, FIELD(first_level), FIELD(offset), FIELD(bytes)),
      RECORD(SelectionView, by_javascript, FIELD(view_projection), FIELD(width_px),
             FIELD(height_px), FIELD(load_cell_px), FIELD(draw_cell_px), FIELD(cell_budget),
             FIELD(ahead), FIELD(occlusion)),
      RECORD(SelectionHeader, by_cpp, FIELD(finest_level), FIELD(coarsest_level),
             FIELD(limited_by_budget), FIELD(undecided)),
      RECORD(DrawnChunk, in_bulk, FIELD(handle), FIELD(regions)),
      RECORD(Visibility, in_bulk, FIELD(handle), FIELD(tested), FIELD(visible)),
      RECORD(Volume, by_javascript, FIELD(voxels), FIELD(spacing), FIELD(origin), FIELD(direction),
             FIELD(value_offset), FIELD(value_scale)),
      RECORD(SampleRange, by_cpp, FIELD(offset), FIELD(count)),
      RECORD(FieldMapping, by_javascript, FIELD(value_offset), FIELD(value_scale),
             FIELD(has_missing)),
      RECORD(Isosurface, by_javascript, FIELD(isovalue), FIELD(colour), FIELD(opacity)),
      RECORD(Appearance, by_javascript, FIELD(colour_low), FIELD(colour_high), FIELD(field_lines),
             FIELD(colour_by), FIELD(colour_map), FIELD(background), FIELD(field_missing),
             FIELD(field_scale), FIELD(field_steps), FIELD(eye_dome)),
      RECORD(Light, by_javascript, FIELD(azimuth), FIELD(elevation), FIELD(key), FIELD(sky),
             FIELD(rim), FIELD(highlight), FIELD(roughness), FIELD(occlusion),
             FIELD(occlusion_radius), FIELD(shadow), FIELD(shadow_softness)),
      RECORD(ClipBox, by_javascript, FIELD(low), FIELD(high), FIELD(caps)),
      RECORD(Plane, by_javascript, FIELD(normal), FIELD(offset)),
      RECORD(Camera, by_both, FIELD(target), FIELD(distance), FIELD(azimuth), FIELD(elevation),
             FIELD(roll), FIELD(field_of_view), FIELD(orthographic)),
      RECORD(Pick, by_cpp, FIELD(position), FIELD(voxel), FIELD(normal), FIELD(gradient),
             FIELD(to_next), FIELD(value), FIELD(field), FIELD(volume), FIELD(isosurface),
             FIELD(level), FIELD(found), FIELD(face), FIELD(has_field)),
      RECORD(Projection, by_cpp, FIELD(clip_from_world)),
      RECORD(FrameStatistics, by_cpp, FIELD(samples_drawn), FIELD(samples_resident),
             FIELD(gpu_bytes), FIELD(chunks_drawn), FIELD(chunks_culled), FIELD(draw_calls),
             FIELD(programs_linked)),
      RECORD(OcclusionAnswer, by_cpp, FIELD(is_ready), FIELD(count)),
  };
}

bool has_gap(const Record& record) {
  size_t end = 0;
  for (const Field& field : record.fields) {
    if (field.offset != end) return true;
    end += field.bytes * std::max<size_t>(field.count, 1);
  }
  return end != record.bytes;
}

std::vector<Constant> all_constants() {
  return {
      {"maxHeaderBytes", kMaxHeaderBytes},
      {"maxIsosurfaces", kMaxIsosurfaces},
      {"maxClipPlanes", kMaxClipPlanes},
      {"maxSlices", kMaxSlices},
      {"colourMapColours", std::extent_v<decltype(kColourMapTable), 1>},
      {"regionWords", ISOSPLAT_REGION_WORDS},
      {"packedSampleBytes", sizeof(PackedSample)},
      {"infoRecord", ISOSPLAT_INFO_RECORD},
      {"infoMetadata", ISOSPLAT_INFO_METADATA},
      {"infoFields", ISOSPLAT_INFO_FIELDS},
      {"samplesPositions", ISOSPLAT_SAMPLES_POSITIONS},
      {"samplesValues", ISOSPLAT_SAMPLES_VALUES},
      {"samplesGradients", ISOSPLAT_SAMPLES_GRADIENTS},
      {"samplesIntervals", ISOSPLAT_SAMPLES_INTERVALS},
      {"decodedSamples", ISOSPLAT_DECODED_SAMPLES},
      {"decodedClusters", ISOSPLAT_DECODED_CLUSTERS},
      {"pointsPositions", ISOSPLAT_POINTS_POSITIONS},
      {"pointsNormals", ISOSPLAT_POINTS_NORMALS},
      {"selectionHeader", ISOSPLAT_SELECTION_HEADER},
      {"selectionLoad", ISOSPLAT_SELECTION_LOAD},
      {"selectionPages", ISOSPLAT_SELECTION_PAGES},
      {"selectionDraw", ISOSPLAT_SELECTION_DRAW},
      {"selectionTest", ISOSPLAT_SELECTION_TEST},
      {"selectionKeep", ISOSPLAT_SELECTION_KEEP},
  };
}

std::vector<Enumeration> all_enumerations() {
  return {{"splatKindNames", names_of<SplatKind>()},
          {"shadingNames", names_of<Shading>()},
          {"colourByNames", names_of<ColourBy>()},
          {"fieldScaleNames", names_of<FieldScale>()},
          {"colourMapNames", names_of<ColourMap>()}};
}

}  // namespace isosplat::layouts
