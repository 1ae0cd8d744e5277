#pragma once

// Replaces the noise effects in the text of a sensor file.

#include <string>

namespace scanmill {

// Returns the text of a sensor file with new effects. `effects`: lines that start with "effects:". They replace the
// file's effects of the same names; range_noise also replaces dropout, shell and quantize, and intensity
// replaces speckle. Other effects of the file,
// such as footprint, are kept before the new ones; everything else, including comments, is unchanged. If the file has
// no effects, the new ones are appended. `file`: name of the file in messages. Throws InputError if the text is not a
// sensor file, or is written in flow style ({...}), in which keys do not have separate lines.
std::string withEffects(const std::string& text, const std::string& file, const std::string& effects);

}  // namespace scanmill
