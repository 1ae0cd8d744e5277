#pragma once

// Reads PLY files: the header, then the numbers behind it.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

struct PlyType {
  char kind = 'U';         // U (unsigned), I (signed) or F (floating-point)
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

// Reads the numbers behind the header of a PLY file, one after the other. In text, each row of an element is a line. If
// the file ends too early or a word is not a number, all functions throw an InputError that names the file, the row
// and, in text, the line.
class PlyBody {
 public:
  // `header` and `bytes`, the whole file, must outlive this object.
  PlyBody(const std::filesystem::path& file, const PlyHeader& header, std::string_view bytes)
      : file_(file.string()), header_(header), bytes_(bytes), at_(header.size), line_(header.lines) {}

  // Begins a row; must be called before numbers of the row are read. `row`: from 0.
  void beginRow(const PlyElement& element, std::uint64_t row);
  // Returns the next number of a row: the property's value or, if the property is a list, its next member.
  double number(const PlyProperty& property) { return next(property, property.value); }
  // Returns the length of a list. Must be called before the list's members are read.
  std::uint64_t length(const PlyProperty& property);
  // Skips a property. In a binary file, a list is skipped as fast as a single value.
  void skip(const PlyProperty& property);
  // Returns the bytes behind the rows that were read.
  std::string_view rest() const { return bytes_.substr(std::min(at_, bytes_.size())); }
  // Ends a row. Throws if words of the line of text are left.
  void endRow();

 private:
  bool isText() const { return header_.format == PlyHeader::Format::Ascii; }
  double next(const PlyProperty& property, const PlyType& type);
  std::string rowName() const;
  [[noreturn]] void fail(const std::string& what) const;

  std::string file_;
  const PlyHeader& header_;
  std::string_view bytes_;
  std::size_t at_;
  int line_;
  std::string_view text_;  // the rest of the line
  const PlyElement* element_ = nullptr;
  std::uint64_t row_ = 0;
};

}  // namespace scanmill
