// A shared library that contains isosplat::core, as plugins and Python extensions do.
#include <isosplat/decoder.h>
#include <isosplat/version.h>

#if ISOSPLAT_VERSION_NUMBER != \
    10000 * ISOSPLAT_VERSION_MAJOR + 100 * ISOSPLAT_VERSION_MINOR + ISOSPLAT_VERSION_PATCH
#error "the version cannot be compared by the preprocessor"
#endif

extern "C" const char* plugin_version() {
  return ISOSPLAT_VERSION;
}

extern "C" isosplat::Decoder* plugin_decoder(const isosplat::Volume* volume) {
  return new isosplat::Decoder(*volume);
}
