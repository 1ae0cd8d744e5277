#pragma once

// Images of materials, decoded to 8 bit RGBA.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "scene/material.h"

namespace scanmill {

// Reads an image with readImage() (images/images.h), and throws the same errors. A file is decoded again only
// if it has changed, or if its texture is no longer in use anywhere. Any thread may call this function.
std::shared_ptr<const Texture> loadTexture(const std::filesystem::path& path);

// Decodes an image that is inside another file. `name` names the image in messages and in Texture::file.
std::shared_ptr<const Texture> decodeTexture(std::string_view bytes, const std::string& name);

// Returns a texture with the colour of `color` (white if null) and the alpha of an opacity map: the map's alpha channel
// or, without one, the brightness that its file stores. `inverted`: inverts the alpha. The result has the larger width
// and the larger height of the two images, which are sampled at the nearest texel.
[[nodiscard]] std::shared_ptr<const Texture> withOpacity(const Texture* color, const Texture& opacity,
                                                         bool inverted = false);

// Returns the linear luminance of an sRGB colour, from 0 to 1 (IEC 61966-2-1, weights of Rec. 709).
float luminance(const std::uint8_t* rgb);

// Returns the mean of luminance() over the texels whose alpha is at least `minimumAlpha`; 1 if there is no such texel.
float meanLuminance(const Texture& texture, float minimumAlpha = 0.0f);

}  // namespace scanmill
