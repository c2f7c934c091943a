#pragma once

namespace isosplat::render {

inline constexpr int kMaxImageSize = 16384;  ///< px, width and height
inline constexpr int kTileMargin = 128;      ///< px; Renderer::draw_tile

/// Displacement of a picture, in pixels.
struct ImageOffset {
  double right = 0, up = 0;
};

/// A rectangle of an image that is drawn separately; by default the whole image. In px, y up as in
/// OpenGL.
struct ImageTile {
  int width = 0, height = 0;
  int image_width = width, image_height = height;
  int left = 0, bottom = 0;  ///< lower left corner in the image

  friend bool operator==(const ImageTile&, const ImageTile&) = default;
};

/// The tile with a margin of this width on each side, as far as the image reaches.
ImageTile with_margin(const ImageTile& tile, int margin);

/// The whole image in fewer pixels, if it has more than `most` to a side.
ImageTile reduced_image(const ImageTile& tile, int most);

}  // namespace isosplat::render
