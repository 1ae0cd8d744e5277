#pragma once

// Writes and reads NumPy's arrays and the ZIP archives that hold them
// (numpy.org/doc/stable/reference/generated/numpy.lib.format.html).

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace scanmill {

// Returns the bytes of a .npy file with an array of this shape; an empty shape is a single number. `descr` is the type
// as NumPy writes it ("<f4", "<u2", "|u1", "<U12"); `bytes` are the elements, little-endian, the last index running
// fastest. Throws Error if `bytes` does not have the size that type and shape require.
std::string npyOf(std::string_view descr, const std::vector<std::size_t>& shape, std::string_view bytes);

// Returns the bytes of a ZIP archive that contains these files, compressed, in this order. Each file is a pair of its
// name in ASCII and its bytes. No time is stored, so the same files always give the same archive. Throws Error if
// libarchive cannot create the archive.
std::string zipOf(std::span<const std::pair<std::string, std::string>> files);

struct NpyArray {
  std::string name;                // file name without .npy
  std::string type;                // first 3 characters of NumPy's type ("<f4"); not a valid type for structured arrays
  std::vector<std::size_t> shape;  // empty for a single number
  std::string bytes;               // elements, last index fastest; if numbers, exactly as many as `shape` says
};

// Returns all .npy files of the archive, in its order. Throws an InputError that begins with `what` if the bytes are
// not a ZIP archive, exceed the limits of base/input_budget.h when unpacked, or an array is damaged, in another format
// than 1.0, in Fortran's order or big-endian.
std::vector<NpyArray> readNpzArrays(std::string_view bytes, const std::string& what);

}  // namespace scanmill
