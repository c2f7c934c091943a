#include <cstdlib>
#include <cstring>

#include "shared/core/sampling/exact_projection.h"
#include "shared/core/sampling/packed_sample.h"

// Any 16 bytes are a packed sample. Unpacking and projecting it does not crash, and the projected
// point is inside the cell.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isosplat;
  PackedSample packed;
  if (size < sizeof packed + sizeof(float)) return 0;
  std::memcpy(&packed, data, sizeof packed);
  float isovalue;
  std::memcpy(&isovalue, data + sizeof packed, sizeof isovalue);

  const UnpackedSample sample = unpack_sample(packed);
  const Trilinear f(sample.corners);
  const Vec3f centre{0.5f, 0.5f, 0.5f};
  const auto point = project_exactly(f, centre, f.at(centre).gradient, isovalue);
  if (!point) return 0;
  for (const float c : {point->x, point->y, point->z}) {
    if (!(c >= -1e-4f && c <= 1.0001f)) std::abort();
  }
  return 0;
}
