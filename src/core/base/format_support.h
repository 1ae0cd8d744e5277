#pragma once

// Tables of what the reader of a file format reads and leaves out. Readers look their elements up in them, and
// `scanmill list inputs` and docs/inputs.md print them.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace scanmill {

// Kinds of elements of a file: statements, XML elements, properties, extensions or columns.
struct FormatElements {
  enum class Use {
    Read,
    Unused,   // changes neither geometry, place, look nor labels, so that no warning names it
    LeftOut,  // counted in the file's warning
  };
  Use use = Use::Read;
  std::string_view names;  // keywords as they stand in files, separated by spaces
  std::string_view note;   // what they mean, or how they are read; in warnings it names what is left out, in the plural
};

struct FormatSupport {
  std::string_view name;      // "OBJ"
  std::string_view suffixes;  // ".obj, .mtl"
  std::vector<FormatElements> elements;

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
  void tell(const std::string& file) const;

 private:
  std::map<std::string, std::uint64_t> counts_;
};

}  // namespace scanmill
