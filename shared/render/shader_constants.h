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

// Side of a square, in the extents of its cell's box on the image, and how far behind the sample
// it is drawn, in extents of the box along the view (measured: tests/bench/render).
#define QUAD_FOOTPRINT 0.87
#define QUAD_SETBACK 0.28

// A chunk whose squares or ellipses may be larger than this, in px, is ray cast instead: what is
// approximate would show, and so few splats that are so large fit on the screen.
#define LARGE_SPLAT_PX 24.0

// Radius of a disc in cells, and how far it reaches beyond its cell's box; the cosine below which a
// disc counts as seen from its edge; and px by which all are enlarged.
#define ELLIPSE_RADIUS 0.87
#define ELLIPSE_MARGIN_CELLS 0.2
#define ELLIPSE_LEAST_FACING 0.1
#define ELLIPSE_LEAST_PX 0.12

// A ray-cast splat accepts roots this far outside of its cell, in cells: neighbours then overlap
// by more than single precision and packed corners can part them.
#define EXACT_MARGIN_CELLS 0.002

// Coarse cells whose corners all lie on one side of an isovalue that is inside their interval hold
// something thinner than a cell: their splats are scaled by this.
#define THIN_FOOTPRINT 0.5

// A blended splat reaches this far beyond its cell, in cells, so that neighbours' normals blend.
#define BLEND_MARGIN_CELLS 0.2

// Fragments of the blended kind this far behind the foremost, in cells, still belong to it.
#define BLEND_DEPTH_CELLS 1.0

// Bits of a surface pixel's fourth channel.
#define COVERAGE_MAX 4095.0
#define ISOSURFACE_SHIFT 12
