#pragma once

#include <filesystem>
#include <string_view>

#include "native/headless/image.h"
#include "shared/core/base/status.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::cli {

/// Writes a picture of a store or a scene: a path with the extension of thumbnails as one that
/// names its content id (server/catalog/thumbnail.h), others as PNG. Errors: io_error, and those of
/// OutputFile.
Result<void> write_picture(const std::filesystem::path& path, const Image& image,
                           std::string_view content);

/// The picture of an isovalue as a thumbnail shows it. Errors: gl_error (this machine cannot draw),
/// those of StoreFile.
Result<Image> picture_of_isovalue(const StoreFile& store, double isovalue);

/// Whether a picture has the file name of the thumbnail of a store or a scene, but does not qualify
/// as one.
bool is_refused_thumbnail(const std::filesystem::path& picture, const std::filesystem::path& file,
                          std::string_view content);

/// Draws a store's thumbnail and writes it beside the store. The thumbnail shows the first
/// suggested isovalue from the page's initial viewpoint, on a transparent background. An existing
/// picture of this content is kept, since the user may have made it, unless it is damaged or too
/// large to be served. Errors: gl_error (this machine cannot draw), invalid_argument (another file
/// has its name), not_found (no isosurface to show), those of StoreFile and of write_picture().
Result<void> draw_thumbnail(const std::filesystem::path& store);

/// The same of a scene (a bundle or a document): its surfaces at the first step, with its camera,
/// or else from the page's initial viewpoint. Errors: those above, of SceneFile and of
/// BundleBytes::plan.
Result<void> draw_scene_thumbnail(const std::filesystem::path& scene);

}  // namespace isosplat::cli
