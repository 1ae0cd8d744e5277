#pragma once

// Tables of the keywords that the reader of a file format knows, and of what it leaves out. Readers look keywords up in
// them, and `scanmill list inputs` and docs/inputs.md print them.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Keywords of a file that have one meaning: statements, XML elements, properties, extensions or columns.
struct FormatElements {
  enum class Use {
    Read,
    Unused,   // changes neither geometry, place, look nor labels, so that no warning names it
    LeftOut,  // counted in the file's warning
  };
  Use use = Use::Read;
  std::string_view names;      // keywords as they stand in files, separated by spaces
  std::string_view note = {};  // what is left out, in the plural, as warnings name it
};

struct FormatSupport {
  std::string_view name;      // "OBJ"
  std::string_view suffixes;  // ".obj, .mtl"
  std::vector<FormatElements> elements;
  std::string_view how = {};          // what is read, and how: sentences without a stop after the last
  std::string_view alsoLeftOut = {};  // what warnings name besides what `elements` leaves out, separated by semicolons

  // Returns the row that names a keyword; null if none does.
  const FormatElements* find(std::string_view keyword) const;
  bool has(FormatElements::Use use, std::string_view keyword) const;
};

// Counts what a reader leaves out of one file.
class LeftOut {
 public:
  // `what`: a noun in the plural.
  void add(const std::string& what, std::uint64_t count = 1);
  // Adds what the table calls a keyword that it leaves out, or the keyword in quotes if the table does not know it.
  // Does nothing for keywords that are read or unused.
  void addKeyword(const FormatSupport& format, std::string_view keyword);
  void add(const LeftOut& other);
  // Adds the bytes that a file has behind what its header states, unless all of them are blanks or zeros.
  void addRest(std::string_view rest);
  bool empty() const { return counts_.empty(); }
  const std::map<std::string, std::uint64_t>& counts() const { return counts_; }
  // Returns, for example, "2 polylines, 1 heightmaps".
  std::string text() const;
  // Warns "FILE: left out: 2 polylines, 1 heightmaps", if anything was added. Three files of a folder are named for the
  // same text; then one warning says that it holds for further ones.
  void warn(const std::string& file) const;

 private:
  std::map<std::string, std::uint64_t> counts_;
};

}  // namespace scanmill
