#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <vector>

#include "native/builder/builder.h"
#include "native/builder/store_with_fields.h"
#include "native/python/exceptions.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::python {

/// Builds a store file, with these fields, on another thread while the calling thread waits without
/// the GIL, handles Ctrl-C and calls `progress(fraction, phase)`, unless it is None, at most every
/// 50 ms. An exception of any of them ends the build: no file appears, and an older one of this
/// name is unchanged. Requires the GIL. Throws the exceptions of raise(), and those of
/// Interruption.
void run_build(const import::OpenVolume& volume, const std::filesystem::path& target,
               BuildOptions options, const pybind11::object& progress, Interruption& interruption,
               std::vector<FieldInput> fields = {});

}  // namespace isosplat::python
