#pragma once

// Hits as an OpenEXR file: an image of columns x rings (width = columns, height = rings, row = ring). The file is
// uncompressed, because reading stored hits must be faster than tracing. 131,072 beams with nine channels take 0.7 ms
// to read and 4.7 MB; with ZIP compression, which can also be read, they take 7.6 ms and 0.9 MB.
//
// A file has these channels, as far as the hits have them: range (float32, m; infinite for a miss), N.X N.Y N.Z,
// instance, semantic, material, primitive (uint32), reflectance, incidence, and roughness, metallic, retroreflectance.
// The channel unresolved (uint32; 1 for a beam that the method could not trace) exists if the hits have such beams.
// Attributes: units, writer.

#include <filesystem>

#include "scan/hits.h"

namespace scanmill {

// Writes hits to an EXR file. The same hits give the same bytes. The file gets its final name only when it is complete.
// Throws Error if the file cannot be written.
void writeHits(const std::filesystem::path& path, const Hits& hits);

// Returns the channels that a file of hits has. Throws InputError if the file is not EXR.
Channels channelsIn(const std::filesystem::path& path);

// Reads the requested channels, and also the surface parameters and the unresolved beams if the file has them, bit for
// bit as they were written. Throws InputError that names the file (and the channel) if the file is not EXR or
// truncated, if a channel is absent or of the wrong type, if a range is NaN or negative, if a class or material is
// above 65535, or if an unresolved beam has a range.
void readHits(const std::filesystem::path& path, Channels requested, Hits& hits);

}  // namespace scanmill
