// What C++ and GLSL must agree on: included by the one, prepended to the other. Only #define lines
// of plain numbers.

// SplatKind.
#define KIND_QUAD 0
#define KIND_ELLIPSE 1
#define KIND_BLENDED 2
#define KIND_EXACT 3

// One layer holds all opaque isosurfaces, and each translucent one has a layer of its own.
#define MAX_ISOSURFACES 8
#define MAX_LAYERS 9

// Clip planes of the settings, and the six of the clip box.
#define MAX_CLIP_PLANES 12

// Width of the texture from which large splats fetch their samples.
#define SAMPLE_TEXTURE_WIDTH 1024

// Squares (measured: tests/bench/render): how much of the normal the extent of a plane's part
// discounts, and how far towards a corner the plane counts as moved, both less than all as surfaces
// bend; px by which squares are enlarged, and bands; how far behind its middle the plane's part is
// drawn, in half its extent along the view; and how far corners must be beyond the plane, in half
// the cell's extent along the normal, to show that there is more than a plane.
#define QUAD_FLATNESS 0.95
#define QUAD_CORNER 0.9
#define QUAD_MARGIN_PX 0.3
#define QUAD_MIN_PX 0.2
#define QUAD_SETBACK 0.7
#define QUAD_BEYOND 0.4

// Side of the tiles by whose farthest depth hidden splats are dropped; those more than twice as
// large never are.
#define HIDING_TILE_PX 8

// Squares count as hidden where they are at places no further apart.
#define QUAD_PROBE_PX 5

// Px per texel of the occluders' image.
#define OCCLUDER_PX 8

// Faces of a cell that each sample of a cluster hides.
#define OCCLUDER_FILL 1.0

// A chunk whose squares or ellipses may be larger than this, in px, is ray cast instead: what is
// approximate would show, and so few splats that are so large fit on the screen.
#define LARGE_SPLAT_PX 24.0

// A fragment of an ellipse belongs to the surface that is this near, in cells, and not further than
// the margin outside of the cell. The cosine below which the tangent plane counts as seen from its
// edge.
#define ELLIPSE_TOLERANCE_CELLS 0.02
#define ELLIPSE_MARGIN_CELLS 0.01
#define ELLIPSE_MIN_FACING 0.1

// A ray-cast splat accepts roots this far outside of its cell, in cells: neighbours then overlap by
// more than single precision can part them, or, where the interval is wide, rounded corners.
#define EXACT_MARGIN_CELLS 0.002
#define ROUNDED_MARGIN_CELLS 0.008

// Splats of coarse cells that hold something thinner than a cell are scaled by no less.
#define THIN_FOOTPRINT 0.4

// A blended splat reaches this far beyond its cell, in cells, so that neighbours' normals blend.
#define BLEND_MARGIN_CELLS 0.2

// Fragments of the blended kind this far behind the foremost, in cells, still belong to it: more
// would blend the two sides of what is thinner than a cell (measured: tests/bench/render).
#define BLEND_DEPTH_CELLS 0.6

// Bits of a surface pixel's fourth channel.
#define COVERAGE_MAX 4095.0
#define ISOSURFACE_SHIFT 12

// Occlusion query: probes of a cell along each axis of the image, at most, where px are counted;
// tiles of a cell along each axis, at most, where it is looked at px by px; by how many px a cell
// is enlarged, and by how much of the depth brought nearer, so that rounding loses none; and how
// far exact splats and ellipses reach beyond their cells at most, in cells.
#define OCCLUSION_PROBES 8
#define OCCLUSION_MAX_TILES 64
#define OCCLUSION_MARGIN_PX 0.25
#define OCCLUSION_MARGIN_CELLS 0.01
#define OCCLUSION_DEPTH_MARGIN 1.5e-7

// A chunk's answer is a row of texels, with four regions in each: 1/255 for each px, up to 255.
#define OCCLUSION_ROW_TEXELS 128
#define OCCLUSION_MAX_PX 255
