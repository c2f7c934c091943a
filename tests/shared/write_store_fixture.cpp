/// Writes the store that the tests in Node open: write_store_fixture FILE.
#include <cstdio>

#include "tests/shared/store_fixture.h"

int main(int count, char** arguments) {
  using namespace isosplat;
  if (count != 2) return 2;
  const Index3 voxels{150, 131, 70};
  const auto levels = fixture::make_levels(voxels, [&](int32_t x, int32_t y, int32_t z) {
    return fixture::rough_ball(voxels, x, y, z);
  });
  const auto store = fixture::make_store(levels, 40);
  std::FILE* file = std::fopen(arguments[1], "wb");
  if (store.empty() || !file) return 1;
  const bool written = std::fwrite(store.data(), 1, store.size(), file) == store.size();
  return std::fclose(file) == 0 && written ? 0 : 1;
}
