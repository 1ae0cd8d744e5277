#pragma once

// Tables of the keywords that the reader of a file format knows, and of what it leaves out. Readers look keywords up in
// them, and `scanmill list inputs` and docs/inputs.md print them.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Keywords of a format: statements, XML elements, properties, extensions or columns of a file. Keywords stand as in
// files; spaces separate those that mean the same or share a line.
struct FormatKeywords {
  struct Row {
    std::string_view names;
    std::string_view note;  // what is left out, in the plural, as warnings name it
  };
  std::vector<std::string_view> read = {};
  std::vector<std::string_view> unused = {};  // change neither geometry, place, look nor labels: no warning names them
  std::vector<Row> leftOut = {};              // counted in the file's warning
};

// States what the reader of a format reads, and what it leaves out.
struct FormatSupport {
  enum class Use { Unknown, Read, Unused, LeftOut };  // Unknown: not in `keywords`

  std::string_view name;              // "OBJ"
  std::string_view suffixes;          // ".obj, .mtl"
  std::string_view how;               // what is read, and how: sentences, the last without a full stop
  std::string_view alsoLeftOut = {};  // what warnings name besides the notes of `keywords`, separated by semicolons
  FormatKeywords keywords = {};

  Use useOf(std::string_view keyword) const;
  // Returns the note of a keyword that is left out; empty for other keywords.
  std::string_view noteOf(std::string_view keyword) const;
};

// Counts what a reader leaves out of one file.
class LeftOut {
 public:
  // Counts things that the reader leaves out. `what`: a noun in the plural, such as "polylines".
  void add(const std::string& what, std::uint64_t count = 1);
  // Counts a keyword of the file: under its note if the format leaves it out, under the keyword in quotes if the format
  // lacks it. Does nothing for keywords that are read or unused.
  void addKeyword(const FormatSupport& format, std::string_view keyword);
  void add(const LeftOut& other);
  // Counts the bytes `rest`, which follow the contents that a file's header states, unless all are blanks or zeros.
  void addRest(std::string_view rest);
  bool empty() const { return counts_.empty(); }
  const std::map<std::string, std::uint64_t>& counts() const { return counts_; }
  // Returns, for example, "2 polylines, 1 heightmaps".
  std::string text() const;
  // Warns "FILE: left out: 2 polylines, 1 heightmaps", if anything was added. If many files of a folder have the same
  // text, warns of the first three files, and then once of all others.
  void warn(const std::string& file) const;

 private:
  std::map<std::string, std::uint64_t> counts_;
};

}  // namespace scanmill
