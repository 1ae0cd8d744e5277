#pragma once

// Hits as an OpenEXR file: an image of columns x rings (width = columns, height = rings, row = ring), uncompressed:
// hits are kept to be read faster than they are traced. 131,072 beams of nine channels take 0.7 ms to read and 4.7 MB;
// ZIP, which is read as well, takes 7.6 ms and 0.9 MB.
//
// Channels, those that there are: range (float32, m; infinite for a miss), N.X N.Y N.Z, instance, semantic, material,
// primitive (uint32), reflectance, incidence, and roughness, metallic, retroreflectance. unresolved (uint32; 1 of a
// beam that the method gave up) is there where such beams are. Attributes: units, writer.

#include <filesystem>

#include "scan/hits.h"

namespace scanmill {

// Under its final name the file is whole. The same hits give the same bytes. Throws Error.
void writeHits(const std::filesystem::path& path, const Hits& hits);

// Returns the channels that a file of hits has. Throws InputError where it is no EXR.
Channels channelsIn(const std::filesystem::path& path);

// Reads the channels asked for (and the surface parameters and the unresolved beams where the file has them), bit
// for bit as they were written. Throws InputError that names the file and the channel: no EXR, truncated, a channel
// absent or of the wrong type, a range that is NaN or negative, a class or material above 65535, a range of an
// unresolved beam.
void readHits(const std::filesystem::path& path, Channels asked, Hits& hits);

}  // namespace scanmill
