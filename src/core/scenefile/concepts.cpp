#include "scenefile/concepts.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <sstream>
#include <utility>

#include "config/fields.h"
#include "config/resources.h"

namespace scanmill {
namespace {

constexpr std::size_t kInside = 5;  // letters; words of at least this length are also found inside longer words

// Two-byte letters of UTF-8 and their replacements.
constexpr std::array<std::pair<std::string_view, std::string_view>, 26> kFolded{
    {{"ß", "ss"}, {"ä", "a"}, {"ö", "o"}, {"ü", "u"}, {"Ä", "a"}, {"Ö", "o"}, {"Ü", "u"}, {"é", "e"}, {"è", "e"},
     {"ê", "e"},  {"à", "a"}, {"â", "a"}, {"á", "a"}, {"ç", "c"}, {"í", "i"}, {"î", "i"}, {"ï", "i"}, {"ñ", "n"},
     {"ó", "o"},  {"ô", "o"}, {"ò", "o"}, {"ú", "u"}, {"û", "u"}, {"ù", "u"}, {"É", "e"}, {"Ñ", "n"}}};

bool isPlural(std::string_view ending) {
  static constexpr std::array<std::string_view, 6> kEndings{"", "s", "es", "e", "n", "en"};
  return std::ranges::find(kEndings, ending) != kEndings.end();
}

struct Match {
  std::size_t end = 0, length = 0;
  bool better(const Match& other) const { return end != other.end ? end > other.end : length > other.length; }
};

// Finds the last place where a word of a concept occurs in a folded name: as a word or its plural, or if `word` is long
// (see kInside), within a word. Returns the index at which the containing word of the name ends, and the length of
// `word`; nothing if there is no such place.
std::optional<Match> lastMatch(std::string_view name, std::string_view word) {
  std::optional<Match> found;
  for (std::size_t at = name.find(word); at != std::string_view::npos; at = name.find(word, at + 1)) {
    const std::size_t blank = std::min(name.find(' ', at + word.size()), name.size());
    const bool begins = at == 0 || name[at - 1] == ' ';
    const bool whole = begins && isPlural(name.substr(at + word.size(), blank - at - word.size()));
    if (whole || word.size() >= kInside) found = Match{blank, word.size()};
  }
  return found;
}

constexpr std::pair<const char*, ConceptKind> kKinds[]{{"ground", ConceptKind::Ground},
                                                       {"whole", ConceptKind::Whole},
                                                       {"detail", ConceptKind::Detail},
                                                       {"drop", ConceptKind::Drop}};

// Replaces each detail without classes by one copy for each concept that it belongs to, with that concept's classes.
std::vector<Concept> withDetails(const std::vector<Concept>& concepts) {
  std::vector<Concept> all;
  for (const Concept& c : concepts) {
    if (c.kind != ConceptKind::Detail || !c.classes.empty()) {
      all.push_back(c);
      continue;
    }
    for (const Concept& whole : concepts) {
      if (std::ranges::find(c.of, whole.name) == c.of.end()) continue;
      all.push_back(c);
      all.back().name = whole.name + " " + c.name;
      all.back().classes = whole.classes;
      all.back().of = {whole.name};
    }
  }
  return all;
}

}  // namespace

std::vector<Concept> readConcepts(const std::filesystem::path& path) {
  const Value root = readYaml(path);
  Fields file(root, "words");
  const std::vector<Value>& list = readList(file.require("concepts"), "concepts");
  file.finish();
  std::vector<Concept> concepts;
  for (const Value& item : list) {
    Fields f(item, "concept");
    Concept c;
    c.name = f.text("name");
    c.classes = f.texts("classes");
    c.material = f.text("material", "");
    c.kind = namedChoice(f, "kind", kKinds, ConceptKind::Whole).second;
    c.of = f.texts("of");
    if (c.kind == ConceptKind::Detail && c.of.empty()) {
      throw InputError(item.where,
                       "a concept of the kind detail needs `of`: the names of the concepts that have this detail");
    }
    c.size = f.range("size", {0, 1e6});
    for (const std::string& word : f.texts("words")) c.words.push_back(foldedName(word));
    f.finish();
    concepts.push_back(std::move(c));
  }
  return withDetails(concepts);
}

const SemanticClass* classOf(const Concept& what, const Ontology& ontology) {
  for (const std::string& wanted : what.classes) {
    if (const SemanticClass* const known = ontology.find(wanted)) return known;
  }
  return nullptr;
}

std::string foldedName(std::string_view name) {
  std::string out;
  bool lower = false;  // true if the previous character was a lower-case or accented letter
  const auto blank = [&] {
    if (!out.empty() && out.back() != ' ') out += ' ';
    lower = false;
  };
  for (std::size_t i = 0; i < name.size();) {
    const auto folded =
        std::ranges::find_if(kFolded, [&](const auto& pair) { return name.substr(i).starts_with(pair.first); });
    if (folded != kFolded.end()) {
      out += folded->second;
      i += folded->first.size();
      lower = true;
      continue;
    }
    const auto c = static_cast<unsigned char>(name[i++]);
    if (std::isalpha(c) == 0) {
      blank();
    } else {
      // "BusStop" is split before the "S"; "CAR" is not split.
      if (std::isupper(c) != 0 && lower) blank();
      out += static_cast<char>(std::tolower(c));
      lower = std::islower(c) != 0;
    }
  }
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

const Concept* conceptOf(const std::vector<Concept>& concepts, std::string_view name) {
  const std::string folded = foldedName(name);
  const Concept* best = nullptr;
  Match match;
  for (const Concept& c : concepts) {
    for (const std::string& word : c.words) {
      const std::optional<Match> found = lastMatch(folded, word);
      if (!found || (best != nullptr && !found->better(match))) continue;
      best = &c;
      match = *found;
    }
  }
  return best;
}

std::vector<const Concept*> conceptsIn(const std::vector<Concept>& concepts, std::string_view name) {
  std::istringstream stream(foldedName(name));
  const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
  const auto isWord = [&](const Concept& c, const std::string& text) {
    return std::ranges::find(c.words, text) != c.words.end();
  };
  std::vector<const Concept*> found;
  for (std::size_t i = 0; i < words.size(); ++i) {
    // Two successive words may be one entry: a "street lamp" is neither a street nor a lamp.
    if (i + 1 < words.size()) {
      const std::string both = words[i] + " " + words[i + 1];
      const auto c = std::ranges::find_if(concepts, [&](const Concept& k) { return isWord(k, both); });
      if (c != concepts.end()) {
        found.push_back(&*c);
        ++i;
        continue;
      }
    }
    if (const Concept* const c = conceptOf(concepts, words[i])) found.push_back(c);
  }
  return found;
}

const SemanticClass& requireClass(const Ontology& ontology, const std::string& name, const Location& where) {
  const std::filesystem::path file = resourceFolder() / "labels/words.yaml";
  if (ontology.find(name) == nullptr && std::filesystem::exists(file)) {
    for (const Concept& c : readConcepts(file)) {
      const bool meant = std::ranges::find(c.words, foldedName(name)) != c.words.end();
      const SemanticClass* const known = meant ? classOf(c, ontology) : nullptr;
      if (known == nullptr) continue;
      throw InputError(
          where, fmt::format("ontology '{}' has no class '{}' (did you mean '{}'?)", ontology.name, name, known->name));
    }
  }
  return ontology.require(name, where);
}

}  // namespace scanmill
