#pragma once

/// ISOSPLAT_CODEC_SIMD: whether there are 128-bit vectors, in the namespace isosplat::simd.
#if defined(__SSE4_1__)
#include "shared/codec/simd_sse.h"
#define ISOSPLAT_CODEC_SIMD 1
#elif defined(__wasm_simd128__)
#include "shared/codec/simd_wasm.h"
#define ISOSPLAT_CODEC_SIMD 1
#else
#define ISOSPLAT_CODEC_SIMD 0
#endif
