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

// A tangent-plane splat reaches this far beyond its cell's box, in cells and in pixels: enough for
// neighbours whose planes differ to overlap (measured: tests/bench/fidelity).
#define PLANE_MARGIN_CELLS 0.15
#define PLANE_MARGIN_PX 0.4

// A ray-cast splat accepts roots this far outside of its cell, in cells: neighbours then overlap
// by more than single precision and packed corners can part them.
#define EXACT_MARGIN_CELLS 0.002

// Coarse cells whose corners all lie on one side of an isovalue that is inside their interval hold
// something thinner than a cell: their splats are scaled by this.
#define THIN_FOOTPRINT 0.5

// Fragments of the blended kind this far behind the foremost, in cells, still belong to it.
#define BLEND_DEPTH_CELLS 1.0

// Fall-off of a blended splat's weight with the squared distance from its centre, in cells.
#define BLEND_FALLOFF 3.0

// Bits of a surface pixel's fourth channel.
#define COVERAGE_MAX 4095.0
#define ISOSURFACE_SHIFT 12
