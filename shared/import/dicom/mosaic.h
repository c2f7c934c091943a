#pragma once

#include <filesystem>
#include <optional>

#include "shared/core/base/vec3.h"
#include "shared/import/dicom/image.h"

// Siemens mosaics: all slices of a volume as tiles of one image, from left to right and from top to
// bottom; the last tiles may be empty. The number of slices and their normal are in private
// elements.
namespace isosplat::import::dicom {

/// Whether a data set says that its image is a mosaic.
bool is_mosaic(const Item& data);

struct Mosaic {
  int slices = 0;
  std::optional<Vec3d> normal;  ///< from the first slice to the last; nothing: unknown
};

/// Reads the private elements of a mosaic. Nothing if they do not state the number of slices.
std::optional<Mosaic> read_mosaic(const Item& data);

/// The numbers of an entry of a CSA header; empty if it is absent, or the header is damaged.
///
///   SV10:        | "SV10" (4) | unused (4) | entries (4) | unused (4) | entry … |
///   before SV10: | entries (4) | unused (4) | entry … |
///   entry:       | name (64) | multiplicity (4) | VR (4) | type (4) | items (4) | mark (4) | …
///   …            | item | item | …
///   item:        | length (4) | length (4) | mark (4) | unused (4) | text, padded to 4 bytes |
///
/// Numbers are little-endian. In SV10 the second length is that of the text; before SV10 it is the
/// first length minus the number of items of the first entry. (The layout is not public; this
/// follows NiBabel's documentation.)
std::vector<double> csa_numbers(std::string_view header, std::string_view name);

}  // namespace isosplat::import::dicom
