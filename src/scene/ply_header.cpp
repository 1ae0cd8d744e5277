#include "scene/ply_header.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr std::size_t kMaxHeader = 1 << 16;  // bytes

std::uint64_t sizeOf(std::string_view type) {
  static constexpr std::array<std::pair<std::string_view, std::uint64_t>, 16> kTypes{{{"char", 1},
                                                                                      {"uchar", 1},
                                                                                      {"int8", 1},
                                                                                      {"uint8", 1},
                                                                                      {"short", 2},
                                                                                      {"ushort", 2},
                                                                                      {"int16", 2},
                                                                                      {"uint16", 2},
                                                                                      {"int", 4},
                                                                                      {"uint", 4},
                                                                                      {"int32", 4},
                                                                                      {"uint32", 4},
                                                                                      {"float", 4},
                                                                                      {"float32", 4},
                                                                                      {"double", 8},
                                                                                      {"float64", 8}}};
  for (const auto& [name, size] : kTypes) {
    if (name == type) return size;
  }
  return 0;
}

std::vector<std::string> words(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> out;
  for (std::string word; stream >> word;) out.push_back(word);
  return out;
}

// What the header has said so far.
struct Header {
  bool binary = false;
  std::uint64_t count = 0;       // of the element that properties are read for
  std::uint64_t properties = 0;  // of all elements
  std::uint64_t leastBytes = 0;  // that the elements so far take up
  bool inElement = false;
};

void readLine(Header& header, const std::vector<std::string>& line, std::uint64_t fileSize, const Location& where) {
  const auto fail = [&](const std::string& what) { throw InputError(where, what); };
  if (line.empty() || line[0] == "comment" || line[0] == "obj_info") return;
  if (line[0] == "format" && line.size() >= 2) {
    header.binary = line[1] != "ascii";
    if (header.binary && line[1] != "binary_little_endian" && line[1] != "binary_big_endian") {
      fail(fmt::format("unknown PLY format '{}'", line[1]));
    }
  } else if (line[0] == "element" && line.size() == 3) {
    const auto [end, error] = std::from_chars(line[2].data(), line[2].data() + line[2].size(), header.count);
    if (error != std::errc() || *end != '\0') fail(fmt::format("'{}' is not a count", line[2]));
    if (header.count > fileSize) {
      fail(fmt::format("the PLY header announces {} of '{}', but the file has {} bytes", header.count, line[1],
                       fileSize));
    }
    header.inElement = true;
  } else if (line[0] == "property" && header.inElement &&
             (line.size() == 3 || (line.size() == 5 && line[1] == "list"))) {
    for (std::size_t i = line.size() == 5 ? 2 : 1; i + 1 < line.size(); ++i) {
      if (sizeOf(line[i]) == 0) fail(fmt::format("unknown PLY type '{}'", line[i]));
    }
    const std::uint64_t size = sizeOf(line[line.size() == 5 ? 2 : 1]);  // a list may be empty
    header.leastBytes += header.count * (header.binary ? size : 2);     // ASCII: a digit and a blank
    ++header.properties;
  } else {
    fail(fmt::format("'{}' is not a line of a PLY header", line[0]));
  }
}

}  // namespace

void checkPlyHeader(const std::filesystem::path& file) {
  std::string text(kMaxHeader, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  const std::uint64_t size = std::filesystem::file_size(file);

  Header header;
  std::size_t at = 0;
  for (int number = 1;; ++number) {
    const std::size_t end = text.find_first_of("\r\n", at);
    if (end == std::string::npos) throw InputError({file.string()}, "is truncated: the PLY header has no end_header");
    const std::vector<std::string> line = words(text.substr(at, end - at));
    at = end + (text.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    const Location where{file.string(), number};
    if (number == 1) {
      if (line != std::vector<std::string>{"ply"}) throw InputError(where, "is not a PLY file");
    } else if (line == std::vector<std::string>{"end_header"}) {
      break;
    } else {
      readLine(header, line, size, where);
    }
  }
  if (header.properties == 0) throw InputError({file.string()}, "the PLY header names no element");
  if (header.leastBytes > size - at + 1) {
    throw InputError({file.string()},
                     fmt::format("is truncated: its elements take {} bytes or more, but {} follow the header",
                                 header.leastBytes, size - at));
  }
}

}  // namespace scanmill
