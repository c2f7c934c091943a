#pragma once

/// ISOSPLAT_CODEC_SIMD: 1 if the target has 128-bit vectors. Then the namespace isosplat::simd has
/// their operations.
#if defined(__SSE4_1__)
#include "shared/core/codec/simd_sse.h"
#define ISOSPLAT_CODEC_SIMD 1
#elif defined(__wasm_simd128__)
#include "shared/core/codec/simd_wasm.h"
#define ISOSPLAT_CODEC_SIMD 1
#else
#define ISOSPLAT_CODEC_SIMD 0
#endif
