#include "formats/ply_file.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstring>
#include <utility>

#include "base/error.h"
#include "base/text_scan.h"
#include "config/resources.h"
#include "formats/text_rows.h"

namespace scanmill {

namespace {

constexpr std::size_t kMaxHeader = 1 << 16;  // largest header (bytes)

PlyType typeOf(std::string_view name, const Location& where) {
  static constexpr std::pair<std::string_view, PlyType> kTypes[] = {
      {"char int8", {'I', 1}}, {"uchar uint8", {'U', 1}}, {"short int16", {'I', 2}},   {"ushort uint16", {'U', 2}},
      {"int int32", {'I', 4}}, {"uint uint32", {'U', 4}}, {"float float32", {'F', 4}}, {"double float64", {'F', 8}}};
  for (const auto& [names, type] : kTypes) {
    if (containsWord(names, name)) return type;
  }
  throw InputError(where, "unknown PLY type '{}'", name);
}

PlyHeader::Format formatOf(std::string_view name, const Location& where) {
  if (name == "ascii") return PlyHeader::Format::Ascii;
  if (name == "binary_little_endian") return PlyHeader::Format::LittleEndian;
  if (name == "binary_big_endian") return PlyHeader::Format::BigEndian;
  throw InputError(where, "unknown PLY format '{}'", name);
}

// Parses a line between `ply` and end_header, and adds its content to `header`. `line`: the words of the line.
void readLine(PlyHeader& header, const std::vector<std::string_view>& line, std::uint64_t fileSize,
              const Location& where) {
  if (line.empty() || line[0] == "comment" || line[0] == "obj_info") return;
  if (line[0] == "format" && line.size() >= 2) {
    header.format = formatOf(line[1], where);
  } else if (line[0] == "element" && line.size() == 3) {
    PlyElement element{std::string(line[1])};
    if (!parseNumber(line[2], element.count)) throw InputError(where, "'{}' is not a count", line[2]);
    if (element.count > fileSize) {
      throw InputError(where, "the PLY header announces {} of '{}', but the file has {} bytes", element.count, line[1],
                       fileSize);
    }
    header.elements.push_back(std::move(element));
  } else if (line[0] == "property" && !header.elements.empty() && line.size() == 3) {
    header.elements.back().properties.push_back({std::string(line[2]), {}, typeOf(line[1], where)});
  } else if (line[0] == "property" && !header.elements.empty() && line.size() == 5 && line[1] == "list") {
    header.elements.back().properties.push_back({std::string(line[4]), typeOf(line[2], where), typeOf(line[3], where)});
  } else {
    throw InputError(where, "'{}' is not a line of a PLY header", line[0]);
  }
}

}  // namespace

PlyHeader readPlyHeader(const std::filesystem::path& file) {
  const std::string text = firstBytes(file, kMaxHeader);
  const std::uint64_t fileSize = std::filesystem::file_size(file);

  PlyHeader header;
  for (std::string_view rest = text;;) {
    if (rest.find('\n') == rest.npos) {
      throw InputError({file.string()},
                       "is truncated: the PLY header has no end_header, or its lines do not end in \\n");
    }
    const std::string_view line = takeLine(rest);
    const Location where{file.string(), ++header.lines};
    if (header.lines == 1) {
      if (line != "ply") throw InputError(where, "is not a PLY file");
    } else if (line == "end_header") {
      header.size = text.size() - rest.size();
      return header;
    } else {
      readLine(header, wordsOf(line), fileSize, where);
    }
  }
}

void PlyBody::beginRow(const PlyElement& element, std::uint64_t row) {
  element_ = &element;
  row_ = row;
  if (!isText()) return;
  if (at_ >= bytes_.size()) fail(fmt::format("is truncated or damaged: it ends within {}", rowName()));
  std::string_view rest = bytes_.substr(at_);
  text_ = takeLine(rest);
  at_ = bytes_.size() - rest.size();
  ++line_;
}

double PlyBody::next(const PlyProperty& property, const PlyType& type) {
  if (isText()) {
    const std::string_view word = takeWord(text_);
    if (word.empty()) fail(fmt::format("{} lacks values: the file is truncated or damaged", rowName()));
    double value = 0;
    readNumber(word, value, property.name, {file_, line_});
    return value;
  }
  if (type.size > bytes_.size() - at_) fail(fmt::format("is truncated or damaged: it ends within {}", rowName()));
  const bool isBigEndian = header_.format == PlyHeader::Format::BigEndian;
  std::uint64_t bits = 0;
  for (std::uint64_t i = 0; i < type.size; ++i) {
    const auto byte = static_cast<unsigned char>(bytes_[at_ + i]);
    bits |= std::uint64_t{byte} << 8 * (isBigEndian ? type.size - 1 - i : i);
  }
  at_ += type.size;
  return visitNumberType(type.kind, type.size, [&]<class T>(T value) {
    std::memcpy(&value, &bits, sizeof(value));  // the first bytes of `bits` are the least significant ones
    return static_cast<double>(value);
  });
}

std::uint64_t PlyBody::length(const PlyProperty& property) {
  constexpr double kMost = 4294967296.0;  // above any 32-bit count
  const double length = next(property, property.count);
  if (length >= 0 && length < kMost) return static_cast<std::uint64_t>(length);
  fail(fmt::format("is damaged: {} has a list with an invalid length", rowName()));
}

void PlyBody::skip(const PlyProperty& property) {
  if (!property.isList()) return void(number(property));
  std::uint64_t remaining = length(property);
  if (isText()) {
    for (; remaining > 0; --remaining) number(property);
  } else if (remaining <= (bytes_.size() - at_) / property.value.size) {
    at_ += remaining * property.value.size;
  } else {
    fail(fmt::format("is truncated or damaged: it ends within {}", rowName()));
  }
}

void PlyBody::endRow() {
  if (!isText() || text_.empty()) return;
  fail(fmt::format("{} has more values than properties ({})", rowName(), element_->properties.size()));
}

std::string PlyBody::rowName() const {
  return fmt::format("'{}' {} of {}", element_->name, row_ + 1, element_->count);
}

void PlyBody::fail(const std::string& what) const {
  throw InputError({file_, isText() ? line_ : 0}, what);
}

}  // namespace scanmill
