#pragma once

// Images of materials, decoded to 8 bit RGBA.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "scene/material.h"

namespace scanmill {

// Reads what images/images.h reads, and throws what it throws. A path is decoded once as long as somebody holds its
// texture, from any thread.
std::shared_ptr<const Texture> loadTexture(const std::filesystem::path& path);

// The same for an image inside another file; `name` stands for it in messages and in Texture::file.
std::shared_ptr<const Texture> decodeTexture(std::string_view bytes, const std::string& name);

// The colour with the alpha of an opacity map: the map's own alpha where it has one, its brightness elsewhere. Without
// a colour, white. The larger of the two sizes; the other is sampled at the nearest texel.
std::shared_ptr<const Texture> withOpacity(const Texture* color, const Texture& opacity, bool inverted = false);

// Linear luminance of an sRGB colour, 0 to 1 (IEC 61966-2-1, Rec. 709 weights).
float luminance(const std::uint8_t* rgb);

// The mean of luminance() over the texels whose alpha is at least `minimumAlpha`; 1 where there is none.
float meanLuminance(const Texture& texture, float minimumAlpha = 0.0f);

}  // namespace scanmill
