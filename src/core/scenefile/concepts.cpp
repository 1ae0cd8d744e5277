#include "scenefile/concepts.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <sstream>
#include <utility>

#include "base/text_scan.h"
#include "config/fields.h"
#include "config/resources.h"

namespace scanmill {
namespace {

// Words of at least this many letters are also found inside longer words. Chosen by eye: shorter words occur inside too
// many other words.
constexpr std::size_t kFewestLettersInside = 5;

// Letters that have two bytes in UTF-8, and the letters by which foldedName() replaces them.
constexpr std::array<std::pair<std::string_view, std::string_view>, 26> kReplacements{
    {{"ß", "ss"}, {"ä", "a"}, {"ö", "o"}, {"ü", "u"}, {"Ä", "a"}, {"Ö", "o"}, {"Ü", "u"}, {"é", "e"}, {"è", "e"},
     {"ê", "e"},  {"à", "a"}, {"â", "a"}, {"á", "a"}, {"ç", "c"}, {"í", "i"}, {"î", "i"}, {"ï", "i"}, {"ñ", "n"},
     {"ó", "o"},  {"ô", "o"}, {"ò", "o"}, {"ú", "u"}, {"û", "u"}, {"ù", "u"}, {"É", "e"}, {"Ñ", "n"}}};

bool hasWord(const Concept& entry, const std::string& foldedWord) {
  return std::ranges::find(entry.words, foldedWord) != entry.words.end();
}

// The match of a concept's word in a name: where the word of the name ends, and the length of the concept's word.
// Matches are compared in this order.
using Match = std::pair<std::size_t, std::size_t>;

// Returns the last match of a concept's word in a folded name; nothing if there is none. The word or its plural must be
// a word of the name. A word of at least kFewestLettersInside letters may also be a part of a word of the name.
std::optional<Match> lastMatch(std::string_view name, std::string_view word) {
  std::optional<Match> match;
  for (std::size_t begin = name.find(word); begin != std::string_view::npos; begin = name.find(word, begin + 1)) {
    const std::size_t wordEnd = std::min(name.find(' ', begin + word.size()), name.size());
    const bool beginsWord = begin == 0 || name[begin - 1] == ' ';
    const std::string_view ending = name.substr(begin + word.size(), wordEnd - begin - word.size());
    const bool isWord = beginsWord && (ending.empty() || containsWord("s es e n en", ending));  // or its plural
    if (isWord || word.size() >= kFewestLettersInside) match = {wordEnd, word.size()};
  }
  return match;
}

constexpr std::pair<const char*, ConceptKind> kKinds[]{{"ground", ConceptKind::Ground},
                                                       {"whole", ConceptKind::Whole},
                                                       {"detail", ConceptKind::Detail},
                                                       {"drop", ConceptKind::Drop}};

// Replaces each detail without classes by one copy for each concept that it belongs to, with that concept's classes.
std::vector<Concept> withDetails(const std::vector<Concept>& concepts) {
  std::vector<Concept> expanded;
  for (const Concept& entry : concepts) {
    if (entry.kind != ConceptKind::Detail || !entry.classes.empty()) {
      expanded.push_back(entry);
      continue;
    }
    for (const Concept& whole : concepts) {
      if (std::ranges::find(entry.wholes, whole.name) == entry.wholes.end()) continue;
      expanded.push_back(entry);
      expanded.back().name = whole.name + " " + entry.name;
      expanded.back().classes = whole.classes;
      expanded.back().wholes = {whole.name};
    }
  }
  return expanded;
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
    Concept entry;
    entry.name = f.text("name");
    entry.classes = f.texts("classes");
    entry.material = f.text("material", "");
    entry.kind = namedChoice(f, "kind", kKinds, ConceptKind::Whole).second;
    entry.wholes = f.texts("of");
    if (entry.kind == ConceptKind::Detail && entry.wholes.empty()) {
      throw InputError(item.where,
                       "a concept of the kind detail needs `of`: the names of the concepts that have this detail");
    }
    entry.size = f.range("size", {0, 1e6});
    for (const std::string& word : f.texts("words")) entry.words.push_back(foldedName(word));
    f.finish();
    concepts.push_back(std::move(entry));
  }
  return withDetails(concepts);
}

const SemanticClass* classOf(const Concept& nameConcept, const Ontology& ontology) {
  for (const std::string& name : nameConcept.classes) {
    if (const SemanticClass* const semanticClass = ontology.find(name)) return semanticClass;
  }
  return nullptr;
}

std::string foldedName(std::string_view name) {
  std::string out;
  bool afterLower = false;  // true if the previous character was a lower-case or accented letter
  const auto endWord = [&] {
    if (!out.empty() && out.back() != ' ') out += ' ';
    afterLower = false;
  };
  for (std::size_t i = 0; i < name.size();) {
    const auto replacement =
        std::ranges::find_if(kReplacements, [&](const auto& pair) { return name.substr(i).starts_with(pair.first); });
    if (replacement != kReplacements.end()) {
      out += replacement->second;
      i += replacement->first.size();
      afterLower = true;
      continue;
    }
    const auto c = static_cast<unsigned char>(name[i++]);
    if (std::isalpha(c) == 0) {
      endWord();
    } else {
      // "BusStop" is split before the "S"; "CAR" is not split.
      if (std::isupper(c) != 0 && afterLower) endWord();
      out += static_cast<char>(std::tolower(c));
      afterLower = std::islower(c) != 0;
    }
  }
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

const Concept* conceptOf(const std::vector<Concept>& concepts, std::string_view name) {
  const std::string folded = foldedName(name);
  const Concept* best = nullptr;
  Match bestMatch;
  for (const Concept& entry : concepts) {
    for (const std::string& word : entry.words) {
      const std::optional<Match> wordMatch = lastMatch(folded, word);
      if (!wordMatch || (best != nullptr && *wordMatch <= bestMatch)) continue;
      best = &entry;
      bestMatch = *wordMatch;
    }
  }
  return best;
}

std::vector<const Concept*> conceptsIn(const std::vector<Concept>& concepts, std::string_view name) {
  std::istringstream stream(foldedName(name));
  const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
  std::vector<const Concept*> nameConcepts;
  for (std::size_t i = 0; i < words.size(); ++i) {
    // Two successive words may be one word of a concept: a "street lamp" is neither a street nor a lamp.
    if (i + 1 < words.size()) {
      const std::string pair = words[i] + " " + words[i + 1];
      const auto entry = std::ranges::find_if(concepts, [&](const Concept& c) { return hasWord(c, pair); });
      if (entry != concepts.end()) {
        nameConcepts.push_back(&*entry);
        ++i;
        continue;
      }
    }
    if (const Concept* const entry = conceptOf(concepts, words[i])) nameConcepts.push_back(entry);
  }
  return nameConcepts;
}

const SemanticClass& requireClass(const Ontology& ontology, const std::string& name, const Location& where) {
  const std::filesystem::path file = resourceFolder() / "labels/words.yaml";
  if (ontology.find(name) == nullptr && std::filesystem::exists(file)) {
    for (const Concept& entry : readConcepts(file)) {
      const SemanticClass* const hint = hasWord(entry, foldedName(name)) ? classOf(entry, ontology) : nullptr;
      if (hint == nullptr) continue;
      throw InputError(where, "ontology '{}' has no class '{}' (did you mean '{}'?)", ontology.name, name, hint->name);
    }
  }
  return ontology.require(name, where);
}

}  // namespace scanmill
