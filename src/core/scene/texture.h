#pragma once

// Images of materials, decoded to 8 bit RGBA.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "scene/material.h"

namespace scanmill {

// Reads an image as readImage() does (images/images.h), and throws what that throws. As long as somebody holds a path's
// texture, it is not decoded again. Any thread may call it.
std::shared_ptr<const Texture> loadTexture(const std::filesystem::path& path);

// Does the same for an image inside another file. `name` stands for it in messages and in Texture::file.
std::shared_ptr<const Texture> decodeTexture(std::string_view bytes, const std::string& name);

// Takes 8 bit RGBA, the top row first: width * height * 4 bytes.
std::shared_ptr<const Texture> plainTexture(std::string_view rgba, std::uint32_t width, std::uint32_t height,
                                            const std::string& name);

// Returns the colour with the alpha of an opacity map, which is the map's own alpha where it has one and its brightness
// where it has none; `inverted` turns it round. Where `color` is null, the colour is white. The result has the size of
// the larger of the two; the other is sampled at the nearest texel.
std::shared_ptr<const Texture> withOpacity(const Texture* color, const Texture& opacity, bool inverted = false);

// The linear luminance of an sRGB colour, from 0 to 1 (IEC 61966-2-1, weights of Rec. 709).
float luminance(const std::uint8_t* rgb);

// The mean of luminance() over the texels whose alpha is at least `minimumAlpha`; 1 where there is none.
float meanLuminance(const Texture& texture, float minimumAlpha = 0.0f);

}  // namespace scanmill
