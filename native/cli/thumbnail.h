#pragma once

#include <filesystem>
#include <string_view>

#include "native/headless/image.h"
#include "shared/core/base/status.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::cli {

/// Writes a picture of a store as a PNG file that names the store's content id
/// (server/catalog/thumbnail.h). Errors: io_error, and those of OutputFile.
Result<void> write_picture(const std::filesystem::path& path, const Image& image,
                           std::string_view content);

/// Whether a picture has the name of the store's thumbnail, and is not allowed as one.
bool is_refused_thumbnail(const std::filesystem::path& picture, const StoreFile& store);

/// Draws a store's thumbnail beside it: its first suggested isovalue, seen as the page does when it
/// opens the volume, on a transparent background. Keeps a picture of this content that is there
/// already, which may be one that the user has made, but not one that is damaged or too large to be
/// served. Errors: gl_error (this machine cannot draw),
/// invalid_argument (another file has its name), not_found (no isosurface to show), those of
/// StoreFile and of write_picture().
Result<void> draw_thumbnail(const std::filesystem::path& store);

}  // namespace isosplat::cli
