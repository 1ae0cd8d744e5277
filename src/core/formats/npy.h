#pragma once

// Writes NumPy's arrays.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Returns the bytes of a .npy file with an array of this shape; an empty shape is a single number. `descr` is the type
// as NumPy writes it ("<f4", "<u2", "|u1", "<U12"); `bytes` are the elements, little-endian, the last index running
// fastest. Throws Error if `bytes` does not have the size that type and shape require.
std::string npyOf(std::string_view descr, const std::vector<std::size_t>& shape, std::string_view bytes);

}  // namespace scanmill
