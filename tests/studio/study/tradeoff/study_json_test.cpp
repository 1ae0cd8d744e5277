#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/random.h"
#include "study/tradeoff/study.h"
#include "tests/studio/study/tradeoff/example_study.h"
#include "tests/support/json_places.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
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
  study.settings[0].measured.cloud.hausdorff = kInfinity;
  study.settings[0].measured.warnings = {"a beam of 'top' lies outside"};
  study.settings[2].measured.cost.residentBytes = std::numeric_limits<std::uint64_t>::max();
  study.settings[2].measured.errors.all.range.mean = 5e-324;
  study.settings[2].measured.errors.byRange[1].errors.nearestTo.p95 = 0.125;
  study.settings[2].measured.errors.byRange[1].errors.nearestFrom.max = 77.5;
  study.ontology.name = "ours";
  study.ontology.classes = {{0, "unlabeled", {0, 0, 0}, false, {}}, {7, "car", {1, 2, 3}, true, {"auto", "vehicle"}}};
  study.rings.resize(2);
  study.pictures = {{"particle refine=none", "particle refine=none", "not kept"}, {"x", "y", {}}};
  return study;
}

std::string refusalOf(const Json& json) {
  return messageOf<InputError>([&] { parseStudy(json.dump(), "t.json"); });
}

// One of a kind is enough to damage.
Json damagedStudy() {
  Study study = wholeStudy();
  study.settings.resize(1);
  for (auto member : {&BeamErrors::byRange, &BeamErrors::byIncidence, &BeamErrors::byPlace, &BeamErrors::byClass}) {
    (study.settings[0].measured.errors.*member).resize(1);
  }
  study.encodings.resize(1);
  study.rings.resize(1);
  study.rings[0].timings.resize(1);
  return Json::parse(toJson(study));
}

TEST(StudyJson, ComesBackToTheByte) {
  for (const Study& study : {wholeStudy(), exampleStudy()}) {
    const std::string text = toJson(study);
    EXPECT_EQ(toJson(parseStudy(text, "t.json")), text);
  }
  Study bare;
  bare.shots = bare.beamsPerShot = 1;
  const std::string text = toJson(bare);
  EXPECT_EQ(toJson(parseStudy(text, "t.json")), text);
  EXPECT_FALSE(parseStudy(text, "t.json").showing.has_value());
}

TEST(StudyJson, HoldsWhatTheReportIsMadeOf) {
  const Study study = wholeStudy();
  const Study read = parseStudy(toJson(study), "t.json");
  ASSERT_EQ(read.settings.size(), study.settings.size());
  EXPECT_EQ(read.settings[1].failure, study.settings[1].failure);
  const Measurement& m = read.settings[0].measured;
  EXPECT_EQ(m.errors.byRange.back().high, kInfinity);
  EXPECT_EQ(m.errors.byRange.front().low, 0.1 + 0.2);
  EXPECT_EQ(m.cloud.hausdorff, kInfinity);
  EXPECT_EQ(m.warnings, study.settings[0].measured.warnings);
  EXPECT_EQ(read.settings[2].measured.cost.residentBytes, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(read.settings[2].measured.errors.all.range.mean, 5e-324);
  EXPECT_EQ(read.settings[2].measured.errors.byRange[1].errors.nearestTo.p95, 0.125);
  EXPECT_EQ(read.settings[2].measured.errors.byRange[1].errors.hausdorff(), 77.5);
  EXPECT_EQ(read.ontology.classes.at(1).aliases, study.ontology.classes[1].aliases);
  ASSERT_TRUE(read.showing.has_value());
  EXPECT_EQ(read.showing->timings.size(), study.showing->timings.size());
  ASSERT_EQ(read.pictures.size(), 2u);
  EXPECT_EQ(read.pictures[0].title, "particle refine=none");
  EXPECT_EQ(read.pictures[0].png, "") << "pictures are files beside it";
  EXPECT_EQ(read.candidates().size(), 3u) << "what failed is no candidate";
}

TEST(StudyJson, FiguresThatAreNoNumberAreAnError) {
  Study study = wholeStudy();
  study.settings[0].measured.cost.scanSeconds = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(messageOf<Error>([&] { toJson(study); }), testing::Not("accepted"));
}

TEST(StudyJson, RefusesEveryMissingKey) {
  const Json json = damagedStudy();
  int tried = 0;
  for (const Json::json_pointer& place : placesIn(json)) {
    const std::string parent = place.parent_pointer().to_string();
    if (!json[place.parent_pointer()].is_object() || place.back() == "aliases" || parent == "/common_stages_s" ||
        parent.ends_with("/stages_s")) {
      continue;
    }
    Json damaged = json;
    damaged[place.parent_pointer()].erase(place.back());
    const std::string message = refusalOf(damaged);
    EXPECT_THAT(message, HasSubstr("t.json")) << place;
    if (place.back() != "kind") {
      EXPECT_THAT(message, HasSubstr("'" + place.back() + "' is missing")) << place;
    }
    ++tried;
  }
  EXPECT_GT(tried, 100);
}

TEST(StudyJson, RefusesEveryWrongType) {
  const Json json = damagedStudy();
  int tried = 0;
  for (const Json::json_pointer& place : placesIn(json)) {
    const Json& right = json[place];
    for (const Json& wrong : {Json(true), Json("x"), Json::array({true}), Json{{"x", true}}}) {
      if (wrong.type() == right.type()) continue;
      if (right.is_null() && wrong.is_object()) continue;  // an optional part
      Json damaged = json;
      damaged[place] = wrong;
      EXPECT_THAT(refusalOf(damaged), HasSubstr("t.json")) << place << " as " << wrong;
      ++tried;
    }
  }
  EXPECT_GT(tried, 300);
}

TEST(StudyJson, RefusesWhatIsNoStudy) {
  const Json json = damagedStudy();
  const std::vector<std::tuple<std::string, Json, std::string>> damages{
      {"/schema_version", Study::kSchemaVersion + 1, "newer than this program"},
      {"/schema_version", Study::kSchemaVersion - 1, "older than this program"},
      {"/schema_version", 0, "/schema_version: 0 is not within 1"},
      {"/schema_version", "1", "/schema_version: is string"},
      {"/kind", "scanmill repeatability", "not a trade-off study"},
      {"/shots", 0, "has no beams"},
      {"/beams_per_shot", 0, "has no beams"},
      {"/shots", -3, "/shots: is number, but must be a whole number"},
      {"/repeats", 1e300, "/repeats"},
      {"/settings/0/measured/cost/scan_s", "fast", "/settings/0/measured/cost/scan_s: is string, but must be a number"},
  };
  for (const auto& [place, value, expected] : damages) {
    Json damaged = json;
    damaged[Json::json_pointer(place)] = value;
    EXPECT_THAT(refusalOf(damaged), HasSubstr(expected)) << place;
  }
  for (const char* text : {"", "[]", "{}", "null", "\"x\"", "\xFF\xFE", "{\"kind\": \"scanmill tradeoff\"}",
                           "{\"kind\": 3}", "{\"schema_version\": 1}"}) {
    EXPECT_THAT(messageOf<InputError>([&] { parseStudy(text, "t.json"); }), HasSubstr("t.json")) << text;
  }
}

TEST(StudyJson, SaysWhereATruncatedFileEnds) {
  const std::string text = toJson(wholeStudy());
  for (std::size_t i = 0; i < 50; ++i) {
    const std::string cut = text.substr(0, i * (text.size() - 2) / 50);
    const auto lines = std::ranges::count(cut, '\n');
    const std::string message = messageOf<InputError>([&] { parseStudy(cut, "t.json"); });
    EXPECT_THAT(message, HasSubstr("is not complete JSON")) << cut.size();
    EXPECT_THAT(message, HasSubstr("t.json:" + std::to_string(lines + 1) + ":")) << cut.size();
  }
}

TEST(StudyJson, NeverCrashesOnFlippedBytes) {
  const std::string text = damagedStudy().dump(1);
  int refused = 0;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const RandomBlock random = randomBlock({.beam = i});
    std::string damaged = text;
    damaged[random[0] % text.size()] = static_cast<char>(random[1]);
    try {
      parseStudy(damaged, "t.json");
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 300);
}

}  // namespace
}  // namespace scanmill
