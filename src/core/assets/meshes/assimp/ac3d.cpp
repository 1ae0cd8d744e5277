#include "assets/meshes/assimp/ac3d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/file.h"

namespace scanmill {
namespace {

// The parts of a line such as `texture "tree.png" base`: the texture's name with its quotes, and its role.
struct Layer {
  std::string_view name, role;
};

Layer layerOf(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r";
  line.remove_prefix(std::string_view("texture").size());
  line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
  const bool quoted = line.starts_with('"');
  std::size_t end = quoted ? line.find('"', 1) : line.find_first_of(kBlank);
  if (quoted && end != std::string_view::npos) ++end;
  if (end == std::string_view::npos) end = line.size();
  std::string_view role = line.substr(end);
  role.remove_prefix(std::min(role.find_first_not_of(kBlank), role.size()));
  role = role.substr(0, role.find_first_of(kBlank));
  return {line.substr(0, end), role};
}

class Ac3dText {
 public:
  Ac3dText(const std::string& text, LeftOut& leftOut) : text_(text), leftOut_(leftOut) { out_.reserve(text.size()); }

  std::string rewrite() {
    out_ += nextLine();
    out_ += '\n';
    while (at_ < text_.size()) {
      const std::string_view line = nextLine();
      const std::string_view key = line.substr(0, line.find_first_of(" \t\r"));
      if (key == "texture") {
        addTexture(line);
        continue;
      }
      writeTexture();
      if (key == "data") {
        skipData(line);
      } else if (key == "MAT") {
        material_ = "MATERIAL" + std::string(trimmed(line.substr(key.size()), " "));
      } else if (key == "ENDMAT") {
        out_ += std::exchange(material_, "") + "\n";
      } else if (!material_.empty()) {
        material_ += trimmed(line, " ");
      } else {
        readLine(key, line);
      }
    }
    writeTexture();
    std::uint64_t missing = 0;
    for (const std::uint64_t kids : kids_) missing += kids;
    leftOut_.add("objects that 'kids' counts and the file lacks", missing);
    if (stated_ > surfaces_) leftOut_.add("surfaces that 'numsurf' counts and the file lacks", stated_ - surfaces_);
    return std::move(out_);
  }

 private:
  std::string_view nextLine() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    const std::string_view line = text_.substr(at_, end - at_);
    at_ = end + 1;
    return line;
  }

  // Returns the text without blanks at both ends, behind `before`.
  static std::string trimmed(std::string_view text, const char* before) {
    const std::size_t from = text.find_first_not_of(" \t\r");
    if (from == std::string_view::npos) return before;
    return before + std::string(text.substr(from, text.find_last_not_of(" \t\r") + 1 - from));
  }

  static std::uint64_t numberIn(std::string_view line) {
    std::uint64_t number = 0;
    const std::size_t from = std::min(line.find_first_of("0123456789"), line.size());
    std::from_chars(line.data() + from, line.data() + line.size(), number);
    return number;
  }

  void readLine(std::string_view key, std::string_view line) {
    if (key == "OBJECT") {
      while (!kids_.empty() && kids_.back() == 0) kids_.pop_back();
      if (!kids_.empty()) --kids_.back();
      if (hidden_ && kids_.size() <= *hidden_) hidden_.reset();
      dropping_ = false;
      object_ = out_.size();
      transform_.clear();
    } else if (key == "rot" || key == "loc") {
      transform_.append(line) += '\n';
      return;
    } else if (key == "kids") {
      kids_.push_back(numberIn(line));
      dropping_ = false;
      if (!transform_.empty()) {
        out_.insert(object_, fmt::format("OBJECT group\n{}kids {}\n", transform_, kids_.back() + 1));
        line = "kids 0";
      }
    } else if (key == "hidden") {
      leftOut_.add("hidden objects");
      if (!hidden_) hidden_ = kids_.size();
    } else if (key == "numvert" || key == "numsurf") {
      dropping_ = hidden_.has_value();
      if (key == "numsurf") stated_ += numberIn(line);
    } else if (key == "refs") {
      ++surfaces_;
    } else if (!key.empty() && std::isalpha(static_cast<unsigned char>(key[0])) != 0) {
      leftOut_.addKeyword(ac3dFormat(), key);
    }
    if (dropping_) return;
    out_ += line;
    out_ += '\n';
  }

  // Skips the text that a line such as "data 12" announces: 12 characters and the end of their line.
  void skipData(std::string_view line) {
    const std::uint64_t length = numberIn(line);
    if (length >= text_.size() - std::min(at_, text_.size())) return;
    at_ += length;
    nextLine();
  }

  void addTexture(std::string_view line) {
    const Layer layer = layerOf(line);
    if (!layer.name.starts_with('"') || base_) return;  // skips empty textures, and textures after the base
    base_ = layer.role == "base";
    if (texture_.empty() || base_) texture_ = layer.name;
  }

  void writeTexture() {
    if (!texture_.empty()) out_ += "texture " + texture_ + "\n";
    texture_.clear();
    base_ = false;
  }

  std::string_view text_;
  LeftOut& leftOut_;
  std::size_t at_ = 0;
  std::string out_;
  std::string texture_;   // texture of the current object; written after the object's last texture line
  bool base_ = false;     // true: texture_ has the role `base`
  std::string material_;  // the material of an open block, in one line; empty: no block is open
  std::uint64_t stated_ = 0, surfaces_ = 0;  // number of surfaces by `numsurf`, and of those in the file
  std::size_t object_ = 0;                   // index in out_ of the current object
  std::string transform_;                    // its lines `rot` and `loc`
  std::vector<std::uint64_t> kids_;          // number of objects that are still to come, by level
  std::optional<std::size_t> hidden_;        // level of the hidden object that is open
  bool dropping_ = false;                    // true: in the vertices or surfaces of a hidden object
};

}  // namespace

const FormatSupport& ac3dFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "AC3D",
      ".ac, .acc, .ac3d",
      {{Read, "OBJECT name kids rot loc", "names and transforms of objects"},
       {Read, "numvert numsurf SURF mat refs subdiv", "surfaces; objects with `subdiv` are subdivided"},
       {Read, "MATERIAL MAT ENDMAT rgb trans",
        "colours and opacity; `rgb` is taken as linear light, since AC3D states no colour space"},
       {Read, "texture texrep texoff", "one image for each object: the first, or the one with the role `base`"},
       {Read, "hidden", "hidden objects and all below them are left out"},
       {Unused, "crease data url locked folded amb emis spec shi", "shading and notes"},
       {LeftOut, "", "lines"}}};
  return format;
}

std::string readAc3d(const std::filesystem::path& file, LeftOut& leftOut) {
  const std::string text = readFile(file);
  return Ac3dText(text, leftOut).rewrite();
}

}  // namespace scanmill
