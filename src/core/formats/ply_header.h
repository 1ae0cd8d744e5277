#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace scanmill {

struct PlyType {
  enum class Kind { Unsigned, Signed, Float };

  Kind kind = Kind::Unsigned;
  std::uint64_t size = 0;  // bytes per value in a binary file
};

struct PlyProperty {
  std::string name;
  PlyType count{};  // type of a list's length; its size is 0 if the property is a single value
  PlyType value{};

  bool isList() const { return count.size > 0; }
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties{};
};

struct PlyHeader {
  enum class Format { Ascii, LittleEndian, BigEndian };

  Format format = Format::Ascii;
  std::vector<PlyElement> elements;
  std::uint64_t size = 0;  // size of the header (bytes)
  int lines = 0;
};

// Reads the header of a PLY file. Throws an InputError that names the file, the line and the fault: there is no
// end_header, a line or type is unknown, or an element has a larger count than the file has bytes.
PlyHeader readPlyHeader(const std::filesystem::path& file);

}  // namespace scanmill
