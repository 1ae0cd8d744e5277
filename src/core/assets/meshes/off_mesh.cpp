#include "assets/meshes/off_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "assets/meshes/imported_file.h"
#include "assets/meshes/stated_unit.h"
#include "base/error.h"
#include "base/file.h"

namespace scanmill {

namespace {

// Translates the text to OBJ, line by line, so that messages of the reader of OBJ name the right lines.
class OffTranslator {
 public:
  OffTranslator(const std::filesystem::path& file, LeftOut& leftOut)
      : text_(readFile(file)), where_{file.string(), 0, 0}, leftOut_(leftOut) {
    if (text_.find('\n') == std::string::npos) std::replace(text_.begin(), text_.end(), '\r', '\n');
    rest_ = text_;
    if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
  }

  std::string_view text() const { return text_; }

  std::string translate() {
    readHead();
    for (std::uint64_t i = 0; i < vertices_; ++i) translateVertex();
    for (std::uint64_t i = 0; i < faces_; ++i) translateFace();
    leftOut_.add("colours of vertices", colored_ ? vertices_ : 0);
    leftOut_.add("colours of faces", coloredFaces_);
    for (std::uint64_t more = 0; nextLine(); ++more) leftOut_.add("lines behind the faces");
    return std::move(obj_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(where_, what); }

  // Goes to the next line that has words.
  bool nextLine() {
    words_.clear();
    while (words_.empty() && !rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      std::string_view line = rest_.substr(0, std::min(rest_.find('#'), end));
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
      ++where_.line;
      constexpr std::string_view kBlanks = " \t\r\v\f";
      for (std::size_t at = line.find_first_not_of(kBlanks); at < line.size();
           at = line.find_first_not_of(kBlanks, at)) {
        const std::size_t stop = std::min(line.find_first_of(kBlanks, at), line.size());
        words_.push_back(line.substr(at, stop - at));
        at = stop;
      }
      if (words_.empty()) obj_ += '\n';
    }
    return !words_.empty();
  }

  void requireLine(std::uint64_t number, const char* what) {
    if (!nextLine()) fail(fmt::format("ends before its {} {}: is it truncated?", number, what));
  }

  std::uint64_t number(std::size_t word, const char* what) const {
    std::uint64_t value = 0;
    const std::string_view text = word < words_.size() ? words_[word] : std::string_view();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) {
      fail(fmt::format("'{}' is not {}", text.substr(0, 40), what));
    }
    return value;
  }

  // The keyword may stand on the line of the counts, or, in some files of ModelNet, directly before them.
  void readHead() {
    requireLine(1, "heading");
    if (const std::size_t off = words_[0].find("OFF"); off != std::string_view::npos) {
      const std::string_view kind = words_[0].substr(0, off);
      if (kind.find_first_not_of("STCN") != std::string_view::npos || (words_.size() > 1 && words_[1] == "BINARY")) {
        fail("is binary, or has not three coordinates for each vertex: convert it to PLY or OBJ");
      }
      colored_ = kind.find('C') != std::string_view::npos;
      words_[0].remove_prefix(off + 3);
      if (words_[0].empty()) words_.erase(words_.begin());
      if (words_.empty()) {
        obj_ += '\n';
        requireLine(2, "counts");
      }
    }
    vertices_ = number(0, "the number of vertices");
    faces_ = number(1, "the number of faces");
    obj_ += '\n';
  }

  void translateVertex() {
    requireLine(vertices_, "vertices");
    if (words_.size() < 3) fail("a vertex must have three coordinates in one line");
    obj_ += fmt::format("v {} {} {}\n", words_[0], words_[1], words_[2]);
  }

  void translateFace() {
    requireLine(faces_, "faces");
    const std::uint64_t corners = number(0, "the number of a face's corners");
    if (corners >= words_.size())
      fail(fmt::format("the face has {} corners, but {} follow", corners, words_.size() - 1));
    if (corners < 3) leftOut_.add("faces of one or two corners");
    if (corners > 2) obj_ += 'f';
    for (std::size_t i = 1; i <= corners && corners > 2; ++i) {
      fmt::format_to(std::back_inserter(obj_), " {}", number(i, "an index of a vertex") + 1);
    }
    obj_ += '\n';
    if (words_.size() > corners + 1) ++coloredFaces_;
  }

  std::string text_;
  std::string_view rest_;  // the text from the next line on
  Location where_;         // the latest line
  LeftOut& leftOut_;
  std::vector<std::string_view> words_;  // of the latest line
  std::string obj_;
  std::uint64_t vertices_ = 0, faces_ = 0, coloredFaces_ = 0;
  bool colored_ = false;  // true if vertices have colours
};

}  // namespace

const FormatSupport& offFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "OFF",
      ".off",
      {{Read, "", "text with three coordinates for each vertex, in double precision; headings of ModelNet, too"},
       {Read, "", "faces of three corners and more; polygons are divided into triangles"},
       {Unused, "", "normals and texture coordinates of vertices (NOFF, STOFF), numbers of edges"},
       {LeftOut, "", "colours of vertices (COFF)"},
       {LeftOut, "", "colours of faces"},
       {LeftOut, "", "faces of one or two corners"},
       {LeftOut, "", "lines behind the faces"}}};
  return format;
}

ImportedFile readOffMesh(const std::filesystem::path& file, const AssetOptions& options) {
  LeftOut leftOut;
  OffTranslator off(file, leftOut);
  warnOfStatedUnit(off.text(), options, file);
  std::string obj = off.translate();
  ImportedFile read = readObjText(std::move(obj), file, options);
  read.leftOut.add(leftOut);
  return read;
}

}  // namespace scanmill
