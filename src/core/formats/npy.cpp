// NumPy's format NPY 1.0 (numpy.org/doc/stable/reference/generated/numpy.lib.format.html): a magic number, the length
// of a header, the header as the text of a Python dictionary, padded so that the elements begin at a multiple of 64
// bytes, and the elements.

#include "formats/npy.h"

#include <fmt/core.h>

#include <charconv>
#include <cstdint>

#include "base/error.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

constexpr std::size_t kAlignment = 64;  // the elements begin at a multiple of this (bytes)
constexpr std::size_t kBeforeHeader = 10;

// Returns the bytes of an element from a NumPy type such as "<f4": the number after byte order and kind, times four for
// text ('U').
std::size_t elementSize(std::string_view descr) {
  std::size_t size = 0;
  const char* const end = descr.data() + descr.size();
  const bool whole = descr.size() > 2 && std::from_chars(descr.data() + 2, end, size).ptr == end;
  if (!whole) throw Error(fmt::format("'{}' is no type of NumPy with a size", descr));
  return descr[1] == 'U' ? 4 * size : size;
}

}  // namespace

std::string npyOf(std::string_view descr, const std::vector<std::size_t>& shape, std::string_view bytes) {
  std::size_t expected = elementSize(descr);
  std::string dimensions;
  for (const std::size_t length : shape) {
    expected *= length;
    dimensions += fmt::format("{}, ", length);
  }
  if (bytes.size() != expected) {
    throw Error(
        fmt::format("{} bytes for an array {} of shape ({}), which has {}", bytes.size(), descr, dimensions, expected));
  }
  // Python writes "(3,)" for one dimension, "(3, 4)" for more.
  if (!dimensions.empty()) dimensions.resize(dimensions.size() - (shape.size() == 1 ? 1 : 2));
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", descr, dimensions);
  const std::size_t used = kBeforeHeader + header.size() + 1;
  header.append((kAlignment - used % kAlignment) % kAlignment, ' ');
  header += '\n';
  if (header.size() > 65535) throw Error(fmt::format("an array of {} dimensions has no NPY 1.0", shape.size()));
  std::string file("\x93NUMPY\x01\x00", 8);
  putNumber(static_cast<std::uint16_t>(header.size()), file);
  file += header;
  file += bytes;
  return file;
}

}  // namespace scanmill
