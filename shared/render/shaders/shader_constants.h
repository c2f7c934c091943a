// Constants of both C++ and GLSL: C++ includes this file, and it is prepended to each shader. Only
// #define lines with plain numbers.

// SplatKind.
#define KIND_QUAD 0
#define KIND_ELLIPSE 1
#define KIND_EXACT 2

// MAX_ISOSURFACES: of a volume. One layer holds all opaque isosurfaces, and each translucent one
// has a separate layer. NO_ISOSURFACE: no index among the isosurfaces of a volume.
#define MAX_ISOSURFACES 8
#define MAX_LAYERS 9
#define NO_ISOSURFACE 15

// Clip planes of the settings, the faces of the clip box, and those of the volume's border.
#define MAX_CLIP_PLANES 18

// Width of the texture of colours, where there are more than MAX_ISOSURFACES isosurfaces.
#define COLOURS_WIDTH 128

// Width of the textures from which large splats fetch their samples and the values of a field, in
// samples; texture unit of the latter.
#define SAMPLE_TEXTURE_WIDTH 1024
#define FIELD_TEXTURE_UNIT 7

// Squares of the quad kind, by measurements with tests/bench/render.
// MARGIN_PX: px by which they reach beyond the crossings. SETBACK: distance by which a square is
// moved back from the middle of its crossings, in half extents of the crossings along the view.
#define QUAD_MARGIN_PX 0.005
#define QUAD_SETBACK 0.15

// Squares whose normal has a smaller component along the view do not record on which side of them
// values are higher: beside an outline they may face either way.
#define QUAD_SIDE_FACING 0.2

// Side of a tile of the farthest depths, in px. MAX_TILES: splats that span more tiles along an
// axis are not tested.
#define HIDING_TILE_PX 8
#define HIDING_MAX_TILES 12

// Largest distance between the points at which a square is tested for occlusion, in px.
#define QUAD_PROBE_PX 5

// Side of a texel of the occluders' depth image, in px.
#define OCCLUDER_PX 8

// Area that each sample of a cluster occludes, in faces of a cell.
#define OCCLUDER_FILL 1.0

// Chunks whose squares or ellipses may be larger than this, in px, are ray cast instead: the
// approximation would be visible, and few splats of this size fit on the screen.
#define LARGE_SPLAT_PX 24.0

// Cells of level 0 whose side may be larger than this, in px, are drawn as triangles instead of
// squares. SLOTS: vertices of a cell in the strip of triangles.
#define TRIANGLE_SIDE_PX 8.0
#define TRIANGLE_SLOTS 16

// Ellipses. Largest distance of a fragment from the surface, in cells; largest distance of a
// fragment from the cell, in cells; smallest cosine between the normal and the ray that is used.
#define ELLIPSE_TOLERANCE_CELLS 0.02
#define ELLIPSE_MARGIN_CELLS 0.01
#define ELLIPSE_MIN_FACING 0.1

// A ray-cast splat accepts roots this far outside of its cell, in cells. Neighbours then overlap in
// spite of errors of single precision, or of rounded corners where the interval is wide.
#define EXACT_MARGIN_CELLS 0.002
#define ROUNDED_MARGIN_CELLS 0.008

// The search for a root ends where the cubic is smaller than this, in the unit of its values.
// Fragments give values in spans of the cell.
#define ROOT_TOLERANCE 1e-4

// Structures thinner than a coarse cell (thin.glsl). LOWER: factor by which the isovalue is
// lowered. SHARE: factor of the estimated share of the cell. LEAST: smallest share. SHEET_VOXELS:
// smallest thickness of a sheet, in voxels of level 0.
#define THIN_LOWER 0.9
#define THIN_SHARE 1.5
#define THIN_LEAST 0.0005
#define THIN_SHEET_VOXELS 0.3

// Smooth normals. REACH_CELLS: distance from its centre, in cells, up to which a cell contributes.
// MAX_TILES: splats that span more tiles are not tested for occlusion.
#define SMOOTH_REACH_CELLS 1.5
#define SMOOTH_MAX_TILES 24

// The texture of gradients at lattice points (lattice.glsl): a page of 8³ texels for each region.
// COLUMNS: pages in a row of pages. PAGE_WIDTH, PAGE_HEIGHT: texels of a page. NEW_PAGE: bit of
// pages that are to be filled. WEIGHT: factor of the gradients. Sums of eight gradients of 65535
// quantized values per cell stay below 65504, the largest 16-bit float. MOST_SQUARE: above that of
// any such sum; cells that several chunks contain are added several times, and may exceed it.
#define LATTICE_COLUMNS 64
#define LATTICE_PAGE_WIDTH 32
#define LATTICE_PAGE_HEIGHT 16
#define LATTICE_NEW_PAGE 32768u
#define LATTICE_WEIGHT 0.0625
#define LATTICE_MOST_SQUARE 2.0e10

// Bits of a surface pixel's fourth channel: isosurface, side.
#define ISOSURFACE_SHIFT 2

// Side of a surface pixel. RISING, FALLING: whether values rise or fall along the ray where it
// crosses the surface. UNKNOWN: it does not cross a surface of the trilinear function. CAP: the
// pixel shows a face of the clipping, where that cuts the solid.
#define SIDE_UNKNOWN 0
#define SIDE_RISING 1
#define SIDE_FALLING 2
#define SIDE_CAP 3

// Caps. SHADE: factor of the isosurface's linear colour. DEPTH_STEP: depth by which the cap of a
// higher isovalue is in front of that of a lower one. TILE_PX: side of a tile of states. BAND_PX:
// expected width of a band of known states (cap_likely.glsl). ESTIMATED: bit of the states that a
// cell gives to positions beside it. BY_CELL: bit of the states that cells at the face give.
// CUT_MARGIN_CELLS: distance from a cell up to which a position on a face belongs to the cell.
#define CAP_SHADE 0.75
#define CAP_DEPTH_STEP 2.4e-7
#define CAP_TILE_PX 8
#define CAP_BAND_PX 1.0
#define CAP_ESTIMATED 16
#define CAP_BY_CELL 16
#define CUT_MARGIN_CELLS 0.002

// Slices. VALUES, NO_DATA: numbers of surface pixels in place of an isosurface; NO_DATA is the
// pattern where no cells are resident. DEPTH_STEP: depth by which the pattern is in front of
// surfaces in the same plane, and by which values are in front of the pattern. MARGIN: distance
// beyond a face, in units of frame space, up to which a position still counts as inside. GREY:
// sRGB, of the pattern. PERIOD_PX: distance between its lines.
#define SLICE_VALUES 16382
#define SLICE_NO_DATA 16383
#define SLICE_DEPTH_STEP 1.2e-7
#define SLICE_MARGIN 0.01
#define SLICE_GREY 0.5
#define SLICE_PERIOD_PX 9.0

// The scalar of surface pixels that show the field of a volume. HIGHEST: of the last colour of the
// map; the first one is 0. MISSING: the value is missing. NO_VALUES: the chunk has no values (yet).
#define FIELD_HIGHEST 65533
#define FIELD_MISSING 65534
#define FIELD_NO_VALUES 65535

// Contour lines of a field. WIDTH_PX: of a line. Lines fade from FULL_DISTANCE_PX of each other,
// and are invisible at LEAST_DISTANCE_PX. OPACITY: of a line. LEAST_SINE: where the gradients of
// field and surface have a smaller angle, the field is constant on the surface, and has no line.
// ROUNDED_SINE: the same where corners are rounded, by up to 1/512 of their span, which turns
// gradients by up to this. The scalar of surface pixels that
// show lines has 12 bits of the position in the colour map (up to LINES_HIGHEST), a bit that is set
// if the line is dark (LINE_TONE), and 3 bits of the share of the pixel that the line covers.
// MISSING and NO_VALUES are the same as without lines.
#define LINE_WIDTH_PX 1.25
#define LINE_FULL_DISTANCE_PX 6.0
#define LINE_LEAST_DISTANCE_PX 3.0
#define LINE_OPACITY 0.9
#define LINE_LEAST_SINE 0.001
#define LINE_ROUNDED_SINE 0.01
#define LINES_HIGHEST 4094
#define LINE_TONE 8

// Occlusion queries. PROBES: largest number of pixels tested along each axis of the image when
// pixels of a cell are counted. MAX_TILES: largest number of tiles along each axis when all pixels
// of a cell are tested. MARGIN_PX, DEPTH_MARGIN: px by which cells are enlarged, and depth by which
// they are moved nearer, against rounding. MARGIN_CELLS: largest distance by which exact splats and
// ellipses reach beyond their cells, in cells.
#define OCCLUSION_PROBES 8
#define OCCLUSION_MAX_TILES 64
#define OCCLUSION_MARGIN_PX 0.25
#define OCCLUSION_MARGIN_CELLS 0.01
#define OCCLUSION_DEPTH_MARGIN 1.5e-7

// The result for a chunk is a row of texels with four regions each: 1/255 per px, up to 255 px.
#define OCCLUSION_ROW_TEXELS 128
#define OCCLUSION_MAX_PX 255

// Edge shading. The factor of a colour is 2^(−strength · SLOPE · s), where s is the sum of log₂ of
// the ratios of depths, at most MOST.
#define EDGE_SHADING_SLOPE 24.0
#define EDGE_SHADING_MOST 0.1

// Upward component and component towards the eye of the direction to the sky's zenith. Tilted
// towards the eye, it models shapes in the shadow of the key light as well.
#define SKY_UP_Y 0.8
#define SKY_UP_Z 0.6

// Still pictures: their number in a mean, slices of the hemisphere per pixel and picture, steps to
// each side in a slice, and steps towards the key light.
#define STILL_PICTURES 8.0
#define AMBIENT_SLICES 2
#define AMBIENT_STEPS 5
#define SHADOW_STEPS 16
