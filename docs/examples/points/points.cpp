// Writes the points of an isosurface, "x y z" in each line: points STORE ISOVALUE
#include <isosplat/decoder.h>
#include <isosplat/file_store.h>

#include <cstdio>
#include <cstdlib>

static int report(const isosplat::Error& error) {
  std::fprintf(stderr, "%s\n", error.message.c_str());
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const double isovalue = std::atof(argv[2]);
  const auto store = isosplat::FileStore::open(argv[1]);
  if (!store) return report(store.error());
  const auto chunks = store->chunks_for(0, isovalue);
  if (!chunks) return report(chunks.error());
  isosplat::Decoder decoder(store->volume());
  isosplat::Cells cells;
  for (const isosplat::Chunk& chunk : *chunks) {
    const auto bytes = store->read_chunk(chunk);
    if (!bytes) return report(bytes.error());
    const auto decoded = decoder.decode(chunk, *bytes, cells);
    if (!decoded) return report(decoded.error());
    for (const isosplat::Vec3d& p : cells.project(isovalue).positions) {
      std::printf("%.17g %.17g %.17g\n", p.x, p.y, p.z);
    }
  }
}
