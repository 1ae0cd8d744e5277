#pragma once

// Reads the arrays of NumPy's archives (numpy.org/doc/stable/reference/generated/numpy.lib.format.html).

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

struct NpyArray {
  std::string name;                // without .npy
  std::string type;                // as NumPy writes it ("<f4"); empty where it has no plain name
  std::vector<std::size_t> shape;  // empty of a single number
  std::string bytes;               // of numbers as many as shape and type say; the last index runs fastest
};

// All files .npy of the archive, in its order. Throws an InputError that begins with `what`: no ZIP archive, an array
// that is damaged, larger than 4 GiB, in Fortran's order or big-endian.
std::vector<NpyArray> readNpzArrays(std::string_view bytes, const std::string& what);

// Of an element of a type that NumPy writes like this, if it is a number of 1 to 8 bytes; else 0.
std::size_t npyNumberBytes(std::string_view type);

}  // namespace scanmill
