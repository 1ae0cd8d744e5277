#include "scenefile/concepts.h"

#include <map>

#include "scene/material.h"
#include "tests/support/labels.h"
#include "tests/support/message_of.h"
#include "tests/support/temporary_folder.h"

namespace scanmill::draft {
namespace {

TEST(Words, NamesAreFolded) {
  EXPECT_EQ(foldedName("Haupt-Straße_01"), "haupt strasse");
  EXPECT_EQ(foldedName("BusStop2"), "bus stop");
  EXPECT_EQ(foldedName("grass.001"), "grass");
  EXPECT_EQ(foldedName("CAR_Red"), "car red");
  EXPECT_EQ(foldedName("__12__"), "");
  EXPECT_EQ(foldedName("Bäume"), "baume");
}

TEST(Words, TheLastOneInANameCounts) {
  const std::vector<Concept> concepts = readConcepts(kLabels / "words.yaml");
  const auto meaning = [&](std::string_view name) {
    const Concept* const c = conceptOf(concepts, name);
    return c == nullptr ? std::string() : c->name;
  };
  for (const auto& [name, concept_] : std::map<std::string, std::string>{
           {"RoadMesh", "road"},
           {"Hauptstraße_12", "road"},
           {"grass-trees-tall", "tree"},
           {"tr-grass.rgb", "terrain"},
           {"Bäume", "tree"},
           {"road_corner", "road"},
           {"StopSign.003", "traffic sign"},
           {"TrafficLight_L", "traffic light"},
           {"bus_stop", "structure"},
           {"city_bus", "bus"},
           {"Leitplanken", "fence"},
           {"maisons", "building"},
           {"bldg_0412", "building"},
           {"SkyDome", "nothing"},
           {"carpet", ""},
           {"Cube.001", ""},
           {"", ""},
       }) {
    EXPECT_EQ(meaning(name), concept_) << name;
  }
}

// Every word means one thing, every concept is a class of ours with a material that there is, and its details are
// there.
TEST(Words, OfTheProgramFitItsLabels) {
  const std::vector<Concept> concepts = readConcepts(kLabels / "words.yaml");
  const Ontology ours = readOntology(kLabels / "scanmill.yaml");
  const MaterialLibrary materials = readMaterials(kLabels / "materials.yaml", 905);
  std::map<std::string, std::string> meanings;
  std::vector<std::string> before;  // details without a class are there once for each of what they are of
  for (const Concept& c : concepts) {
    for (const std::string& word : c.words) {
      if (c.kind == ConceptKind::Detail && c.words == before) break;
      EXPECT_TRUE(meanings.emplace(word, c.name).second) << word << " means " << meanings[word] << " and " << c.name;
    }
    before = c.words;
    const auto knows = [&](const Ontology& ontology) {
      return std::any_of(c.classes.begin(), c.classes.end(), [&](const std::string& name) {
        return std::any_of(ontology.classes.begin(), ontology.classes.end(),
                           [&](const SemanticClass& known) { return known.name == name; });
      });
    };
    EXPECT_TRUE(c.classes.empty() || knows(ours)) << c.name;
    if (!c.material.empty()) {
      EXPECT_NO_THROW(materials.require(c.material, {})) << c.name;
    }
    for (const std::string& whole : c.wholes) {
      EXPECT_TRUE(std::any_of(concepts.begin(), concepts.end(), [&](const Concept& o) { return o.name == whole; }))
          << c.name << " of " << whole;
    }
  }
}

TEST(Words, AWordIsNoClassButNamesOne) {
  const Ontology ontology = readOntology(kLabels / "scanmill.yaml");
  EXPECT_EQ(requireClass(ontology, "truck", {}).name, "truck");
  for (const std::string name : {"lorry", "LKW", "trukc"}) {
    expectInputError(
        [&] {
          requireClass(ontology, name, {"a.yaml", 3, 4});
        },
        {"a.yaml:3:4", "has no class '" + name, "did you mean 'truck'?"});
  }
}

TEST(Words, BadFilesAreRefusedWithTheirPlace) {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& text, const std::vector<std::string>& words) {
    const std::filesystem::path file = folder.write("words.yaml", text);
    expectInputError([&] { readConcepts(file); }, words);
  };
  refuse("concepts: 3\n", {"words.yaml:1", "list"});
  refuse("concepts:\n  - {name: a, kind: hole, words: [b]}\n", {"words.yaml:2", "hole"});
  refuse("concepts:\n  - {name: wheel, kind: detail, words: [wheel]}\n", {"words.yaml:2", "of"});
  refuse("concepts:\n  - {name: a, size: [1], words: [b]}\n", {"words.yaml:2", "size"});
  refuse("concepts:\n  - {nam: a}\n", {"words.yaml:2", "name"});
}

}  // namespace
}  // namespace scanmill::draft
