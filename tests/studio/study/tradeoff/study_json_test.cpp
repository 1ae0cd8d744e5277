#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "study/tradeoff/study.h"
#include "tests/studio/study/tradeoff/example_study.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Everything that a study can hold, open bands and unlikely texts too.
Study wholeStudy() {
  Study study = exampleStudy();
  study.settings.resize(4);
  study.settings[1].failure = "it said \"no\",\nthen nothing: Straße\t\\";
  study.settings[1].measured = {};
  BeamErrors& e = study.settings[0].measured.errors;
  e.byRange.back().high = kInfinity;
  e.byRange.front().low = 0.1 + 0.2;
  e.byLength.back().high = kInfinity;
  study.settings[0].measured.warnings = {"a beam of 'top' lies outside"};
  study.settings[2].measured.cost.residentBytes = std::numeric_limits<std::uint64_t>::max();
  study.settings[2].measured.errors.all.range.mean = 5e-324;
  study.settings[2].measured.errors.byRange[1].errors.nearestTo.p95 = 0.125;
  study.settings[2].measured.errors.byRange[1].errors.nearestFrom.max = 77.5;
  study.ontology.name = "ours";
  study.ontology.classes = {{0, "unlabeled", {0, 0, 0}, false, {}}, {7, "car", {1, 2, 3}, true, {"auto", "vehicle"}}};
  study.pictures = {{"particle refine=none", "not kept"}, {"x", {}}};
  return study;
}

TEST(StudyJson, HoldsWhatTheReportIsMadeOf) {
  const Study study = wholeStudy();
  const Json json = Json::parse(toJson(study));
  EXPECT_EQ(json.at("kind"), "scanmill tradeoff");
  EXPECT_EQ(json.at("schema_version"), Study::kSchemaVersion);
  ASSERT_EQ(json.at("settings").size(), study.settings.size());
  EXPECT_EQ(json["settings"][1].at("failure"), study.settings[1].failure);
  const Json& measured = json["settings"][0].at("measured");
  EXPECT_TRUE(measured.at("errors").at("by_range").back().at("high").is_null()) << "an open band";
  EXPECT_EQ(measured["errors"]["by_range"].front().at("low"), 0.1 + 0.2);
  EXPECT_EQ(measured.at("warnings"), Json(study.settings[0].measured.warnings));
  const Json& third = json["settings"][2].at("measured");
  EXPECT_EQ(third.at("cost").at("resident_bytes"), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(third.at("errors").at("all").at("range_m").at("mean"), 5e-324);
  EXPECT_EQ(third["errors"].at("by_range").at(1).at("errors").at("nearest_to_m").at("p95"), 0.125);
  EXPECT_EQ(third["errors"]["by_range"][1]["errors"].at("nearest_from_m").at("max"), 77.5);
  EXPECT_EQ(json.at("ontology").at("classes").at(1).at("aliases"), Json({"auto", "vehicle"}));
  ASSERT_EQ(json.at("pictures").size(), 2u);
  EXPECT_EQ(json["pictures"][0], (Json{{"setting", "particle refine=none"}, {"title", "particle refine=none"}}))
      << "pictures are files beside it";
}

TEST(StudyJson, FiguresThatAreNoNumberAreAnError) {
  Study study = wholeStudy();
  study.settings[0].measured.cost.scanSeconds = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(messageOf<Error>([&] { toJson(study); }), "accepted");
}

}  // namespace
}  // namespace scanmill
