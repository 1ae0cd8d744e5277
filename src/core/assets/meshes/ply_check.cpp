#include "assets/meshes/ply_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr double kMaxList = 4294967296.0;  // limit of a list's length, above any 32-bit count

[[noreturn]] void failTruncated(const Location& where, const PlyElement& element, std::uint64_t row) {
  throw InputError(where, fmt::format("is truncated or damaged: it ends within '{}' {} of {}", element.name, row + 1,
                                      element.count));
}

[[noreturn]] void failCount(const Location& where, const PlyElement& element, std::uint64_t row) {
  throw InputError(where, fmt::format("is damaged: '{}' {} of {} has a list with an invalid length", element.name,
                                      row + 1, element.count));
}

// Returns a number as a count; nullopt if it is negative, NaN or not below kMaxList.
std::optional<std::uint64_t> countOf(double value) {
  return value >= 0 && value < kMaxList ? std::optional(static_cast<std::uint64_t>(value)) : std::nullopt;
}

// Reads numbers of a binary file, and skips bytes without reading them.
class BinaryWalk {
 public:
  BinaryWalk(const std::filesystem::path& file, std::uint64_t at, bool bigEndian)
      : stream_(file, std::ios::binary), at_(at), size_(std::filesystem::file_size(file)), bigEndian_(bigEndian) {}

  std::uint64_t left() const { return size_ - at_; }

  bool skip(std::uint64_t bytes) {
    if (bytes > left()) return false;
    at_ += bytes;
    return true;
  }

  // Returns the next number, which is of the given type. The file must have enough bytes left.
  double number(const PlyType& type) {
    if (at_ < first_ || at_ + type.size > last_) fill();
    std::uint64_t bits = 0;
    for (std::uint64_t i = 0; i < type.size && at_ + i < last_; ++i) {
      const std::uint64_t byte = static_cast<unsigned char>(buffer_[at_ - first_ + i]);
      bits |= byte << 8 * (bigEndian_ ? type.size - 1 - i : i);
    }
    at_ += type.size;
    if (type.kind == PlyType::Kind::Float) {
      return type.size == 8 ? std::bit_cast<double>(bits)
                            : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    }
    const double range = static_cast<double>(std::uint64_t{1} << 8 * type.size);
    const bool negative = type.kind == PlyType::Kind::Signed && bits >> (8 * type.size - 1) != 0;
    return static_cast<double>(bits) - (negative ? range : 0.0);
  }

 private:
  void fill() {
    stream_.seekg(static_cast<std::streamoff>(at_));
    stream_.read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    first_ = at_;
    last_ = at_ + static_cast<std::uint64_t>(stream_.gcount());
    stream_.clear();
  }

  std::ifstream stream_;
  std::uint64_t at_;
  std::uint64_t size_;
  bool bigEndian_;
  std::array<char, 1 << 16> buffer_{};
  std::uint64_t first_ = 0;  // the part of the file in the buffer is [first_, last_)
  std::uint64_t last_ = 0;
};

void checkBinary(const std::filesystem::path& file, const PlyHeader& header) {
  BinaryWalk walk(file, header.size, header.format == PlyHeader::Format::BigEndian);
  for (const PlyElement& element : header.elements) {
    const auto& properties = element.properties;
    if (std::none_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.isList(); })) {
      std::uint64_t row = 0;
      for (const PlyProperty& property : properties) row += property.value.size;
      if (!walk.skip(row * element.count)) failTruncated({file.string()}, element, walk.left() / row);
      continue;
    }
    for (std::uint64_t row = 0; row < element.count; ++row) {
      for (const PlyProperty& property : properties) {
        std::uint64_t values = 1;
        if (property.isList()) {
          if (walk.left() < property.count.size) failTruncated({file.string()}, element, row);
          const auto count = countOf(walk.number(property.count));
          if (!count) failCount({file.string()}, element, row);
          values = *count;
        }
        if (!walk.skip(values * property.value.size)) failTruncated({file.string()}, element, row);
      }
    }
  }
}

// Removes the next word from the line and returns it; empty at the end of the line.
std::string_view nextWord(std::string_view& line) {
  constexpr std::string_view kBlank = " \t\r";
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlank));
  line.remove_prefix(word.size());
  return word;
}

// Throws InputError if a line of an ASCII file, which may be empty, lacks values of the element's row `row` (counted
// from 0), or if a word is not a number. Additional words at the end of the line are ignored.
void checkRow(const PlyElement& element, std::uint64_t row, std::string_view line, const Location& where) {
  const auto word = [&] {
    const std::string_view found = nextWord(line);
    if (found.empty()) {
      throw InputError(where, fmt::format("'{}' {} of {} lacks values: the file is truncated or damaged", element.name,
                                          row + 1, element.count));
    }
    double number = 0;
    const std::string_view digits = found.substr(found[0] == '+' ? 1 : 0);
    const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (read.ptr != digits.data() + digits.size()) {
      throw InputError(where,
                       fmt::format("'{}' is not a number such as 1234.5 or -1.2e-3, with a decimal point", found));
    }
    return found;
  };
  for (const PlyProperty& property : element.properties) {
    std::uint64_t values = 1;
    if (property.isList()) {
      const std::string_view text = word();
      double number = -1;
      std::from_chars(text.data(), text.data() + text.size(), number);
      const auto count = countOf(number);
      if (!count) failCount(where, element, row);
      values = *count;
    }
    for (std::uint64_t i = 0; i < values; ++i) word();
  }
}

void checkAscii(const std::filesystem::path& file, const PlyHeader& header) {
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(header.size));
  const char newline = header.isMac ? '\r' : '\n';
  Location where{file.string(), header.lines};
  std::string line;
  for (const PlyElement& element : header.elements) {
    if (element.properties.empty()) continue;
    for (std::uint64_t row = 0; row < element.count; ++row) {
      ++where.line;
      if (!std::getline(stream, line, newline)) failTruncated({file.string()}, element, row);
      checkRow(element, row, line, where);
    }
  }
}

// Throws InputError for files that the importer would silently misread or complete with invented data.
void requireMesh(const std::filesystem::path& file, const PlyHeader& header) {
  for (const PlyElement& element : header.elements) {
    if (element.name == "tristrips" && element.count > 0) {
      throw InputError({file.string()}, "has triangle strips, which are not supported: export it with faces");
    }
    if (element.name != "vertex") continue;
    for (const char* axis : {"x", "y", "z"}) {
      const auto is = [&](const PlyProperty& p) { return p.name == axis && !p.isList(); };
      if (std::none_of(element.properties.begin(), element.properties.end(), is)) {
        throw InputError({file.string()},
                         fmt::format("its vertices have no property {}: export it with x, y and z", axis));
      }
    }
  }
}

}  // namespace

const FormatSupport& plyMeshFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "PLY of triangles",
      ".ply with faces",
      {{Read, "vertex face x y z vertex_indices vertex_index", "triangles"},
       {Read, "s t u v texture_u texture_v texcoord", "texture coordinates"},
       {Read, "material material_index material_indices", "materials"},
       {Unused, "nx ny nz normal_x normal_y normal_z quality confidence curvature radius flags texnumber camera",
        "normals and measures"},
       {LeftOut, "red green blue alpha r g b a diffuse_red diffuse_green diffuse_blue", "channels of colours"},
       {LeftOut, "edge", "elements 'edge'"},
       {LeftOut, "", "all other properties of vertices and faces, such as labels, and all other elements"}}};
  return format;
}

void tellLeftOut(const PlyHeader& header, const std::filesystem::path& file) {
  LeftOut leftOut;
  for (const PlyElement& element : header.elements) {
    if (element.count > 0) leftOut.addKeyword(plyMeshFormat(), element.name);
    if (element.name != "vertex" && element.name != "face") continue;
    for (const PlyProperty& property : element.properties) leftOut.addKeyword(plyMeshFormat(), property.name);
  }
  leftOut.tell(file.string());
}

PlyHeader checkPly(const std::filesystem::path& file) {
  PlyHeader header = readPlyHeader(file);
  if (std::all_of(header.elements.begin(), header.elements.end(),
                  [](const PlyElement& element) { return element.properties.empty(); })) {
    throw InputError({file.string()}, "the PLY header names no element");
  }
  requireMesh(file, header);
  if (header.format == PlyHeader::Format::Ascii) {
    checkAscii(file, header);
  } else {
    checkBinary(file, header);
  }
  tellLeftOut(header, file);
  return header;
}

}  // namespace scanmill
