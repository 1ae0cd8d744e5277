#include "formats/ply_header.h"

#include <fmt/core.h>

#include <array>
#include <charconv>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr std::size_t kMaxHeader = 1 << 16;  // largest header (bytes)

PlyType typeOf(const std::string& name, const Location& where) {
  using enum PlyType::Kind;
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{{{"char", {Signed, 1}},
                                                                                {"uchar", {Unsigned, 1}},
                                                                                {"int8", {Signed, 1}},
                                                                                {"uint8", {Unsigned, 1}},
                                                                                {"short", {Signed, 2}},
                                                                                {"ushort", {Unsigned, 2}},
                                                                                {"int16", {Signed, 2}},
                                                                                {"uint16", {Unsigned, 2}},
                                                                                {"int", {Signed, 4}},
                                                                                {"uint", {Unsigned, 4}},
                                                                                {"int32", {Signed, 4}},
                                                                                {"uint32", {Unsigned, 4}},
                                                                                {"float", {Float, 4}},
                                                                                {"float32", {Float, 4}},
                                                                                {"double", {Float, 8}},
                                                                                {"float64", {Float, 8}}}};
  for (const auto& [known, type] : kTypes) {
    if (known == name) return type;
  }
  throw InputError(where, fmt::format("unknown PLY type '{}'", name));
}

std::vector<std::string> words(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> out;
  for (std::string word; stream >> word;) out.push_back(word);
  return out;
}

PlyHeader::Format formatOf(const std::string& name, const Location& where) {
  if (name == "ascii") return PlyHeader::Format::Ascii;
  if (name == "binary_little_endian") return PlyHeader::Format::LittleEndian;
  if (name == "binary_big_endian") return PlyHeader::Format::BigEndian;
  throw InputError(where, fmt::format("unknown PLY format '{}'", name));
}

void readLine(PlyHeader& header, const std::vector<std::string>& line, std::uint64_t fileSize, const Location& where) {
  if (line.empty() || line[0] == "comment" || line[0] == "obj_info") return;
  if (line[0] == "format" && line.size() >= 2) {
    header.format = formatOf(line[1], where);
  } else if (line[0] == "element" && line.size() == 3) {
    PlyElement element{line[1]};
    const auto [end, error] = std::from_chars(line[2].data(), line[2].data() + line[2].size(), element.count);
    if (error != std::errc() || *end != '\0') throw InputError(where, fmt::format("'{}' is not a count", line[2]));
    if (element.count > fileSize) {
      throw InputError(where, fmt::format("the PLY header announces {} of '{}', but the file has {} bytes",
                                          element.count, line[1], fileSize));
    }
    header.elements.push_back(std::move(element));
  } else if (line[0] == "property" && !header.elements.empty() && line.size() == 3) {
    header.elements.back().properties.push_back({line[2], {}, typeOf(line[1], where)});
  } else if (line[0] == "property" && !header.elements.empty() && line.size() == 5 && line[1] == "list") {
    header.elements.back().properties.push_back({line[4], typeOf(line[2], where), typeOf(line[3], where)});
  } else {
    throw InputError(where, fmt::format("'{}' is not a line of a PLY header", line[0]));
  }
}

}  // namespace

PlyHeader readPlyHeader(const std::filesystem::path& file) {
  std::string text(kMaxHeader, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  const std::uint64_t fileSize = std::filesystem::file_size(file);

  PlyHeader header;
  for (std::size_t at = 0;;) {
    const std::size_t end = text.find_first_of("\r\n", at);
    if (end == std::string::npos) throw InputError({file.string()}, "is truncated: the PLY header has no end_header");
    const std::vector<std::string> line = words(text.substr(at, end - at));
    const bool isTwo = text.compare(end, 2, "\r\n") == 0 && !header.isMac;  // in Mac files "\n" would be data
    at = end + (isTwo ? 2 : 1);
    const Location where{file.string(), ++header.lines};
    if (header.lines == 1) {
      if (line != std::vector<std::string>{"ply"}) throw InputError(where, "is not a PLY file");
      header.isMac = text[end] == '\r' && !isTwo;
    } else if (line == std::vector<std::string>{"end_header"}) {
      header.size = at;
      return header;
    } else {
      readLine(header, line, fileSize, where);
    }
  }
}

}  // namespace scanmill
