// STL, in text and in binary form ("StereoLithography Interface Specification", 3D Systems, 1989). The keywords of the
// text may be in upper case. Each `solid` is a node; a binary file is one node without a name. A file is binary if its
// size is that of the number of triangles in its header, or if it does not begin with `solid`.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/imported_file.h"
#include "base/error.h"
#include "base/file.h"
#include "base/text_scan.h"
#include "config/text.h"

namespace scanmill {

namespace {

constexpr std::size_t kStlHeader = 80;  // size of a binary file's header without the number of triangles (bytes)
constexpr std::size_t kStlFacet = 50;   // bytes of a triangle: normal, three corners, two attribute bytes

class StlReader {
 public:
  StlReader(const std::filesystem::path& file, const AssetOptions& options)
      : file_(file), options_(options), text_(readFile(file)) {}

  ImportedFile read() {
    isText() ? readText() : readBinary();
    return imported();
  }

 private:
  struct Solid {
    std::string name;
    std::size_t first;  // index of its first corner
  };

  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_.string(), line_}, what); }

  std::uint64_t statedTriangles() const {
    std::uint32_t count = 0;
    if (text_.size() >= kStlHeader + sizeof count) std::memcpy(&count, text_.data() + kStlHeader, sizeof count);
    return count;
  }

  // Many binary files begin with "solid", too.
  bool isText() const {
    if (text_.size() == kStlHeader + 4 + kStlFacet * statedTriangles()) return false;
    const std::string_view head = std::string_view(text_).substr(0, 1024);
    const std::size_t first = head.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    return first != std::string_view::npos && lowerCase(head.substr(first, 5)) == "solid" &&
           head.find('\0') == std::string_view::npos;
  }

  void readBinary() {
    const std::uint64_t stated = statedTriangles();
    const std::size_t first = kStlHeader + 4;
    const std::size_t held = text_.size() < first ? 0 : (text_.size() - first) / kStlFacet;
    if (text_.size() < first || held < stated) {
      fail(fmt::format("is truncated, or not an STL file: its header states {} triangles, {} follow", stated, held));
    }
    checkCount(stated);
    imported_.leftOut.add("bytes behind the triangles", text_.size() - first - stated * kStlFacet);
    if (text_.substr(0, kStlHeader).find("COLOR=") != std::string::npos) {
      imported_.leftOut.add("colours in the header (COLOR=)");
    }
    solids_.push_back({"", 0});
    corners_.reserve(3 * stated);
    std::uint64_t colored = 0;
    for (std::size_t i = 0; i < stated; ++i) {
      std::array<float, 12> numbers{};
      const char* const facet = text_.data() + first + i * kStlFacet;
      std::memcpy(numbers.data(), facet, sizeof numbers);
      for (std::size_t k = 3; k < 12; k += 3) corners_.emplace_back(Vec3f{numbers[k], numbers[k + 1], numbers[k + 2]});
      if (facet[48] != 0 || facet[49] != 0) ++colored;
    }
    imported_.leftOut.add("colours of triangles (attribute bytes)", colored);
  }

  void readText() {
    line_ = 1;
    bool inSolid = false;
    bool inFacet = false;
    std::vector<Vec3d> loop;
    for (std::string word = lowerCase(nextWord()); !word.empty(); word = lowerCase(nextWord())) {
      if (word == "solid" || word.ends_with("\xBFsolid")) {
        solids_.push_back({std::string(restOfLine()), corners_.size()});
        inSolid = true;
      } else if (word == "endsolid") {
        restOfLine();
        inSolid = false;
      } else if (word == "facet" || word == "endfacet") {
        inFacet = word == "facet";
        for (int i = 0; inFacet && i < 4; ++i) nextWord();  // "normal" and its three numbers
      } else if (word == "vertex") {
        Vec3d corner;
        for (double* const value : {&corner.x, &corner.y, &corner.z}) {
          const std::string_view number = nextWord();
          if (!parseNumber(number, *value)) fail(fmt::format("'{}' is not a number of a vertex", number.substr(0, 40)));
        }
        loop.push_back(corner);
      } else if (word == "endloop") {
        addLoop(loop);
        loop.clear();
      } else if (word != "normal" && word != "outer" && word != "loop") {
        imported_.leftOut.add(fmt::format("unknown '{}'", word.substr(0, 40)));
        restOfLine();
      }
    }
    if (inFacet) fail("ends within a facet: is it truncated?");
    if (inSolid) imported_.problems.emplace_back("the last solid has no 'endsolid'");
  }

  void addLoop(const std::vector<Vec3d>& loop) {
    if (loop.size() < 3) imported_.leftOut.add("facets of fewer than three corners");
    if (solids_.empty()) solids_.push_back({"", 0});
    for (std::size_t i = 2; i < loop.size(); ++i) corners_.insert(corners_.end(), {loop[0], loop[i - 1], loop[i]});
    checkCount(corners_.size() / 3);
  }

  void checkCount(std::uint64_t triangles) const {
    if (triangles > kMostTriangles) fail(fmt::format("has more than {} triangles: split it", kMostTriangles));
  }

  // Returns the next word of the text; empty at its end.
  std::string_view nextWord() {
    std::string_view rest = std::string_view(text_).substr(at_);
    const std::string_view word = takeWord(rest);
    const auto blanks = static_cast<std::ptrdiff_t>(text_.size() - rest.size() - word.size() - at_);
    const auto from = text_.begin() + static_cast<std::ptrdiff_t>(at_);
    line_ += static_cast<int>(std::count(from, from + blanks, '\n'));
    at_ = text_.size() - rest.size();
    return word;
  }

  std::string_view restOfLine() {
    const std::size_t end = std::min(text_.find_first_of("\r\n", at_), text_.size());
    const std::string_view rest = std::string_view(text_).substr(at_, end - at_);
    at_ = end;
    return trimmed(rest);
  }

  ImportedFile imported() {
    imported_.up = options_.up.value_or('z');
    imported_.materials.emplace_back().stated = false;
    const Mat3 frame = assetFromFile(imported_.up, options_.metresPerUnit);
    for (Vec3d& corner : corners_) corner = frame * corner;
    // Coordinates of binary files are in single precision, so that an origin would not refine them.
    if (line_ > 0) imported_.origin = originNear(corners_.size(), [this](std::size_t i) { return corners_[i]; });
    for (std::size_t k = 0; k < solids_.size(); ++k) {
      AssetPart& part = imported_.parts.emplace_back();
      part.node = std::move(solids_[k].name);
      part.nodeIndex = static_cast<std::uint32_t>(imported_.parts.size());
      const std::size_t end = k + 1 < solids_.size() ? solids_[k + 1].first : corners_.size();
      for (std::size_t i = solids_[k].first; i < end; ++i) {
        part.positions.push_back(static_cast<Vec3f>(corners_[i] - imported_.origin));
      }
      const auto corners = static_cast<std::uint32_t>(part.positions.size());
      for (std::uint32_t i = 0; i < corners; i += 3) part.triangles.push_back({i, i + 1, i + 2});
      weld(part.positions, part.uvs, part.triangles);
    }
    std::erase_if(imported_.parts, [](const AssetPart& part) { return part.triangles.empty(); });
    return std::move(imported_);
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  std::string text_;
  std::size_t at_ = 0;  // index of the character behind the latest word
  int line_ = 0;        // line of the latest word, counted from 1; 0: the file is binary
  std::vector<Solid> solids_;
  std::vector<Vec3d> corners_;  // three per triangle, in the file's units and axes
  ImportedFile imported_;
};

}  // namespace

const FormatSupport& stlFormat() {
  static const FormatSupport format{"STL",
                                    ".stl",
                                    {},
                                    "Text in double precision, and binary files, those that begin with 'solid' too; a "
                                    "file may hold several solids, whose names are those of nodes. Loops of more than "
                                    "three corners are divided into triangles",
                                    "colours of triangles (attribute bytes) and in the header (COLOR=)"};
  return format;
}

ImportedFile readStlMesh(const std::filesystem::path& file, const AssetOptions& options) {
  return StlReader(file, options).read();
}

}  // namespace scanmill
