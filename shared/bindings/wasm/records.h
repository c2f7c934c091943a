#pragma once

#include <stdint.h>

/// The records that cross between the core and JavaScript, and the limits that both sides use.
///
/// This is the only description of these records. layouts.cpp lists their fields once more; the
/// build fails if a field is missing there. From the list, the program write_layouts generates the
/// module `layouts.js`, with which JavaScript reads and writes them. So TypeScript contains no
/// offsets and no sizes.
///
/// Numbers are little-endian. No record has padding: write_layouts asserts it. Numbers that may
/// exceed 32 bits are doubles. Booleans are 0 or 1. Colours are sRGB, 0 … 1.
#ifdef __cplusplus
extern "C" {
#endif

enum {
  ISOSPLAT_REGION_WORDS = 16  ///< of a RegionMask: two per slice, the low half first
};

/// A chunk of the open store: ChunkRef, and its handle.
typedef struct IsosplatChunk {
  double offset;    ///< in the file
  uint32_t handle;  ///< a small number that stays the same while the store is open
  uint32_t level;
  uint32_t block[3];  ///< index in blocks of the level
  uint32_t band;
  uint32_t band_begin, band_end;  ///< quantized values, half-open
  uint32_t bytes;
  uint32_t cells;
  uint32_t checksum;
  uint32_t block_cells[3];  ///< cells of the block
} IsosplatChunk;

/// The properties of a chunk that decoding needs besides its bytes. decode_packed does not read
/// `block`.
typedef struct IsosplatChunkShape {
  uint32_t block_cells[3];
  uint32_t band_begin, band_end;
  uint32_t cells;
  uint32_t level;
  uint32_t block[3];
} IsosplatChunkShape;

/// A block of a level.
typedef struct IsosplatBlock {
  uint32_t level;
  uint32_t block[3];
} IsosplatBlock;

/// A directory page.
typedef struct IsosplatPage {
  double offset;  ///< in the file
  uint32_t bytes;
  uint32_t level;
  uint32_t first_block[3];
  uint32_t resident;
  uint32_t interval_min, interval_max;
} IsosplatPage;

/// StoreInfo, without its metadata.
typedef struct IsosplatStoreInfo {
  double spacing[3];
  double origin[3];
  double direction[9];  ///< row by row
  double value_offset, value_scale, max_error;
  double chunk_count, missing_voxels, file_bytes;
  uint32_t voxels[3];
  uint32_t bits;
  uint32_t has_missing;
  uint32_t min_quantized, max_quantized;
  uint32_t levels;
  uint8_t content_id[16];
} IsosplatStoreInfo;

/// A field of the open store, and where it lies: FieldRef. Of an open field: the field itself, and
/// 0 for its place.
typedef struct IsosplatField {
  double value_offset, value_scale, max_error;
  double missing_voxels;
  double offset, bytes;  ///< in the store file
  uint32_t bits;
  uint32_t has_missing;
  uint32_t min_quantized, max_quantized;
  uint8_t name[64];  ///< ASCII, followed by zeros
} IsosplatField;

/// A byte range of the store file: CoarseRange.
typedef struct IsosplatCoarseRange {
  double first_level, offset, bytes;
} IsosplatCoarseRange;

/// SelectionView, without its isovalues.
typedef struct IsosplatSelectionView {
  double view_projection[16];  ///< column by column
  double width_px, height_px;
  double load_cell_px, draw_cell_px;
  double cell_budget;
  uint32_t ahead;  ///< a predicted view: see Selector::select_ahead
  uint32_t occlusion;
} IsosplatSelectionView;

/// The single numbers of a Selection. The levels are −1 if nothing is drawn.
typedef struct IsosplatSelectionHeader {
  int32_t finest_level, coarsest_level;
  uint32_t limited_by_budget;
  uint32_t undecided;
} IsosplatSelectionHeader;

/// A chunk to draw, and the regions of its block in which to draw it (RegionMask).
typedef struct IsosplatDrawnChunk {
  uint32_t handle;
  uint32_t regions[ISOSPLAT_REGION_WORDS];
} IsosplatDrawnChunk;

/// The answer of an occlusion query for one chunk.
typedef struct IsosplatVisibility {
  uint32_t handle;
  uint32_t tested[ISOSPLAT_REGION_WORDS];   ///< the regions that were drawn
  uint32_t visible[ISOSPLAT_REGION_WORDS];  ///< those of them that may be visible
} IsosplatVisibility;

/// The properties of a volume that the renderer needs.
typedef struct IsosplatVolume {
  double voxels[3];  ///< doubles, so that any number from outside can be checked
  double spacing[3];
  double origin[3];
  double direction[9];  ///< row by row
  double value_offset, value_scale;
} IsosplatVolume;

/// Where the samples of a chunk lie in their vertex buffer.
typedef struct IsosplatSampleRange {
  double offset;  ///< in bytes
  double count;   ///< of samples
} IsosplatSampleRange;

/// The mapping of a field's values: ValueMapping.
typedef struct IsosplatFieldMapping {
  double value_offset, value_scale;
  double has_missing;  ///< 0 or 1
} IsosplatFieldMapping;

/// Isosurface.
typedef struct IsosplatIsosurface {
  double isovalue;
  float colour[3];
  float opacity;
} IsosplatIsosurface;

/// The part of RenderSettings that decides the colours.
typedef struct IsosplatAppearance {
  double colour_low, colour_high;  ///< the range of the quantity that the colour map shows
  double field_lines;              ///< distance of contour lines; 0: none
  uint32_t colour_by;              ///< ColourBy
  uint32_t colour_map;             ///< ColourMap
  float background[4];             ///< with alpha
  float field_missing[3];          ///< colour where a field has no value
  uint32_t field_scale;            ///< FieldScale
  uint32_t field_steps;            ///< number of colours that show fields; below 2: all of the map
  float eye_dome;
} IsosplatAppearance;

/// LightSettings.
typedef struct IsosplatLight {
  float azimuth, elevation;
  float key, sky, rim;
  float highlight, roughness;
  float occlusion, occlusion_radius;
  float shadow, shadow_softness;
} IsosplatLight;

/// The clip box of RenderSettings, in fractions of the volume's extent.
typedef struct IsosplatClipBox {
  double low[3], high[3];
  double caps;  ///< 0 or 1: RenderSettings::clip_caps, also of the clip planes
} IsosplatClipBox;

/// Plane.
typedef struct IsosplatPlane {
  double normal[3];
  double offset;
} IsosplatPlane;

/// Camera.
typedef struct IsosplatCamera {
  double target[3];
  double distance;
  double azimuth, elevation, roll;
  double field_of_view;
  double orthographic;  ///< 0 or 1
} IsosplatCamera;

/// SurfacePick. `found` is 0 if there is no surface; the other numbers are 0 then.
typedef struct IsosplatPick {
  double position[3], voxel[3], normal[3];
  double gradient, to_next;
  double value;
  double field;  ///< of the volume's field; NaN where it is missing
  uint32_t volume;
  uint32_t isosurface;  ///< index among those of the volume
  uint32_t level;
  uint32_t found;
  uint32_t face;       ///< 0: an isosurface; 1: a cap; 2: a slice
  uint32_t has_field;  ///< 0 or 1: `field` is known
} IsosplatPick;

/// Projection::clip_from_world, column by column.
typedef struct IsosplatProjection {
  double clip_from_world[16];
} IsosplatProjection;

/// FrameStatistics.
typedef struct IsosplatFrameStatistics {
  double samples_drawn, samples_resident;
  double gpu_bytes;
  uint32_t chunks_drawn, chunks_culled;
  uint32_t draw_calls;
  uint32_t programs_linked;
} IsosplatFrameStatistics;

/// The state of an occlusion query.
typedef struct IsosplatOcclusionAnswer {
  uint32_t is_ready;
  uint32_t count;  ///< chunks in the answer; 0 until it is ready
} IsosplatOcclusionAnswer;

#ifdef __cplusplus
}
#endif
