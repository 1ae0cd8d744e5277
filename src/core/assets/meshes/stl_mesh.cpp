// Reads STL files, text or binary ("StereoLithography Interface Specification", 3D Systems, 1989). The keywords of a
// text may be in upper case. Each `solid` is a node; a binary file is one node without a name. A file is binary if its
// size fits the number of triangles in its header, or if it does not begin with `solid`.

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
#include "formats/little_endian.h"

namespace scanmill {

namespace {

// Layout of a binary file (bytes): a text, the number of triangles and, for each triangle, its normal and its three
// corners in float32 and two attribute bytes.
constexpr std::size_t kTextBytes = 80;
constexpr std::size_t kHeaderBytes = kTextBytes + 4;
constexpr std::size_t kFacetBytes = 50;
constexpr std::size_t kAttributesAt = 48;  // offset of the attribute bytes

class StlReader {
 public:
  StlReader(const std::filesystem::path& file, const AssetOptions& options)
      : file_(file), options_(options), text_(readFile(file)) {}

  ImportedFile read() {
    isText() ? readText() : readBinary();
    makeParts();
    return std::move(imported_);
  }

 private:
  struct Solid {
    std::string name;
    std::size_t first;  // index of the solid's first corner in corners_
  };

  [[noreturn]] void fail(const std::string& problem) const { throw InputError({file_.string(), line_}, problem); }

  // Returns the number of triangles in the header of a binary file.
  std::uint64_t statedTriangles() const {
    return text_.size() < kHeaderBytes ? 0 : numberAt<std::uint32_t>(text_, kTextBytes);
  }

  // True if the file is a text. Its first word does not suffice: many binary files begin with "solid", too.
  bool isText() const {
    if (text_.size() == kHeaderBytes + kFacetBytes * statedTriangles()) return false;
    const std::string_view head = std::string_view(text_).substr(0, 1024);
    const std::size_t first = head.find_first_not_of(" \t\r\n\xEF\xBB\xBF");  // blanks and byte order mark
    return first != std::string_view::npos && lowerCase(head.substr(first, 5)) == "solid" &&
           head.find('\0') == std::string_view::npos;
  }

  void readBinary() {
    const std::uint64_t triangles = statedTriangles();
    const std::size_t fullFacets = text_.size() < kHeaderBytes ? 0 : (text_.size() - kHeaderBytes) / kFacetBytes;
    if (text_.size() < kHeaderBytes || fullFacets < triangles) {
      fail(fmt::format("is truncated, or not an STL file: its header states {} triangles, {} follow", triangles,
                       fullFacets));
    }
    checkCount(triangles);
    imported_.leftOut.add("bytes behind the triangles", text_.size() - kHeaderBytes - triangles * kFacetBytes);
    if (text_.substr(0, kTextBytes).find("COLOR=") != std::string::npos) {
      imported_.leftOut.add("colours in the header (COLOR=)");
    }
    solids_.push_back({"", 0});
    corners_.reserve(3 * triangles);
    std::uint64_t coloredTriangles = 0;
    for (std::size_t i = 0; i < triangles; ++i) {
      std::array<Vec3f, 4> normalAndCorners;
      const char* const facet = text_.data() + kHeaderBytes + i * kFacetBytes;
      std::memcpy(normalAndCorners.data(), facet, sizeof normalAndCorners);
      for (const std::size_t k : {1u, 2u, 3u}) corners_.emplace_back(normalAndCorners[k]);
      if (facet[kAttributesAt] != 0 || facet[kAttributesAt + 1] != 0) ++coloredTriangles;
    }
    imported_.leftOut.add("colours of triangles (attribute bytes)", coloredTriangles);
  }

  void readText() {
    line_ = 1;
    bool inSolid = false;
    bool inFacet = false;
    std::vector<Vec3d> loop;  // corners of the current facet
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

  // Adds the triangles of a facet, as a fan; they belong to the latest solid.
  void addLoop(const std::vector<Vec3d>& loop) {
    if (loop.size() < 3) imported_.leftOut.add("facets of fewer than three corners");
    if (solids_.empty()) solids_.push_back({"", 0});
    for (std::size_t i = 2; i < loop.size(); ++i) corners_.insert(corners_.end(), {loop[0], loop[i - 1], loop[i]});
    checkCount(corners_.size() / 3);
  }

  void checkCount(std::uint64_t triangles) const {
    if (triangles > kMostTriangles) fail(fmt::format("has more than {} triangles: split it", kMostTriangles));
  }

  // Returns the next word of the text, or an empty word at the end. Counts the lines before the word.
  std::string_view nextWord() {
    const std::string_view textBefore = unread_;
    const std::string_view word = takeWord(unread_);
    const std::size_t blanks = textBefore.size() - unread_.size() - word.size();
    line_ += static_cast<int>(std::ranges::count(textBefore.substr(0, blanks), '\n'));
    return word;
  }

  std::string_view restOfLine() {
    const std::string_view line = unread_.substr(0, std::min(unread_.find_first_of("\r\n"), unread_.size()));
    unread_.remove_prefix(line.size());
    return trimmed(line);
  }

  // Makes a part of each solid that has triangles.
  void makeParts() {
    imported_.materials.emplace_back().stated = false;
    placePositions(corners_, line_ > 0, options_, imported_);  // binary files have coordinates in float32
    for (std::size_t k = 0; k < solids_.size(); ++k) {
      AssetPart& part = imported_.parts.emplace_back();
      part.node = std::move(solids_[k].name);
      part.nodeIndex = static_cast<std::uint32_t>(imported_.parts.size());
      const std::size_t end = k + 1 < solids_.size() ? solids_[k + 1].first : corners_.size();
      for (std::size_t i = solids_[k].first; i < end; ++i) {
        part.positions.push_back(static_cast<Vec3f>(corners_[i] - imported_.origin));
      }
      makeTriangles(part);
    }
    std::erase_if(imported_.parts, [](const AssetPart& part) { return part.triangles.empty(); });
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  std::string text_;                // bytes of the file, text or binary
  std::string_view unread_{text_};  // text that nextWord() has not read yet
  int line_ = 0;                    // line of the latest word, counted from 1; 0: the file is binary
  std::vector<Solid> solids_;
  std::vector<Vec3d> corners_;  // three per triangle, in the file's units and axes
  ImportedFile imported_;
};

}  // namespace

const FormatSupport kStlFormat{
    "STL", ".stl",
    "Text in double precision, and binary files, those that begin with 'solid' too; a file may hold several solids, "
    "whose names are those of nodes. Loops of more than three corners are divided into triangles",
    "colours of triangles (attribute bytes) and in the header (COLOR=)"};

ImportedFile readStlMesh(const std::filesystem::path& file, const AssetOptions& options) {
  return StlReader(file, options).read();
}

}  // namespace scanmill
