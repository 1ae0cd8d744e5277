#pragma once

// Arrays of NumPy.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// The bytes of a file .npy with an array of this shape, an empty one being a single number. `descr` is the type as
// NumPy writes it ("<f4", "<u2", "|u1", "<U12"); `bytes` are the elements, little-endian, the last index running
// fastest. Throws Error where there are more or fewer bytes than the shape has room for.
std::string npyOf(std::string_view descr, const std::vector<std::size_t>& shape, std::string_view bytes);

}  // namespace scanmill
