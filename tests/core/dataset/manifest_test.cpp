#include "dataset/manifest.h"

#include <bit>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "dataset/names.h"
#include "tests/core/dataset/fixture.h"
#include "tests/support/json_places.h"

namespace scanmill {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using OrderedJson = nlohmann::ordered_json;

std::string refusalOfText(const OrderedJson& json) {
  return messageOf<InputError>([&] { parseManifest(json.dump(), "manifest.json"); });
}

// Returns the refusal of the document with another value at `place`.
std::string refusalWith(const OrderedJson& json, const std::string& place, const OrderedJson& value) {
  OrderedJson damaged = json;
  damaged[OrderedJson::json_pointer(place)] = value;
  return refusalOfText(damaged);
}

// Returns what is read from the text of a manifest. The text of that must be the same.
Manifest readBack(const Manifest& manifest) {
  const std::string text = toJson(manifest);
  Manifest read = parseManifest(text, "manifest.json");
  EXPECT_EQ(toJson(read), text);
  return read;
}

// Keys that are left out where they say nothing new.
Manifest manifestWithAllKeys() {
  Manifest m = filledManifest();
  m.sensors[0].intensityFullScale = 255;
  m.sensors[1].vehicleFromSensor.reset();
  for (SampleRecord& sample : m.samples) sample.scans[1].vehicleFromSensor = Pose{{}, {1, 2, 3}};
  m.samples[0].objects = {{65535, {12, 7}}};
  m.samples[1].objects.emplace();
  m.samples[1].draws = {{"effects.0.weather.kind", "fog"}, {"objects.0.town.length", "253.25", true}};
  m.samples[1].time = 0.25;
  ScanRecord& scan = m.samples[1].scans[0];
  scan.unresolved = 5;
  scan.revolution = 1;
  return m;
}

TEST(Manifest, RoundTrips) {
  const Manifest m = filledManifest();
  const Manifest read = readBack(m);
  EXPECT_EQ(read.samples[1].scans[0].worldFromSensor, m.samples[1].scans[0].worldFromSensor);
  EXPECT_EQ(read.sequenceOf(m.samples[1].key), read.sequences.data());
  EXPECT_EQ(read.sequenceOf("street-2-drive-000001"), nullptr);
  EXPECT_EQ(mountOf(m.sensors[0], m.samples[0].scans[0]), m.sensors[0].vehicleFromSensor);
  for (std::size_t s = 0; s < m.sensors.size(); ++s) {
    BeamTable beams = read.sensors[s].beams;
    fillBeams(beams);
    EXPECT_EQ(beams.direction, m.sensors[s].beams.direction);
    EXPECT_EQ(beams.origin, m.sensors[s].beams.origin);
    EXPECT_EQ(beams.time, m.sensors[s].beams.time);
  }
}

TEST(Manifest, KeysOfRareFactsAreWrittenWhereThereAreSuch) {
  const OrderedJson with = OrderedJson::parse(toJson(manifestWithAllKeys())),
                    without = OrderedJson::parse(toJson(filledManifest()));
  const Manifest read = readBack(manifestWithAllKeys());
  EXPECT_EQ(read.samples[1].draws, manifestWithAllKeys().samples[1].draws);
  EXPECT_TRUE(read.samples[1].objects.has_value());
  EXPECT_FALSE(readBack(filledManifest()).samples[1].objects.has_value());
  EXPECT_EQ(mountOf(read.sensors[1], read.samples[1].scans[1]).translation, (Vec3d{1, 2, 3}));
  EXPECT_FALSE(with["sensors"][1].contains("vehicle_from_sensor"));
  EXPECT_EQ(with["samples"][1]["draws"]["objects.0.town.length"], 253.25);
  EXPECT_EQ(OrderedJson::parse(sampleJson(read.samples[1]))["scans"][0]["unresolved"], 5);
  const std::tuple<const char*, OrderedJson, const char*> damages[] = {
      {"/samples/1/scans/0/unresolved", 0, "0 is not within 1"},
      {"/samples/1/scans/0/unresolved", 1'000'000, "is not within 1"},
      {"/samples/1/draws/effects.0", true, "must be a number"},
      {"/samples/0/objects/0/with_points", 13, "13 is not within 0 to 12"},
      {"/samples/0/objects/0/id", 5, "class 5 is not in ontology"},
      {"/sensors/0/intensity_full_scale", 0, "0 is not within"},
  };
  for (const auto& [place, value, words] : damages) {
    EXPECT_FALSE(without.contains(OrderedJson::json_pointer(place))) << place;
    EXPECT_THAT(refusalWith(with, place, value), AllOf(HasSubstr(words), HasSubstr("/"))) << place;
  }
  OrderedJson lost = with;
  lost["samples"][1]["scans"][1].erase("vehicle_from_sensor");
  EXPECT_THAT(refusalOfText(lost), HasSubstr("/samples/1/scans/1: key 'vehicle_from_sensor' is missing"));
}

TEST(Manifest, KeepsEveryBitOfADouble) {
  Manifest m = filledManifest();
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const RandomBlock random = randomBlock({.beam = i});
    const double value = std::bit_cast<double>(std::uint64_t{random[0]} << 32 | random[1]);
    if (!std::isfinite(value)) continue;
    m.samples[0].scans[0].time = value;
    const Manifest read = parseManifest(toJson(m), "manifest.json");
    EXPECT_EQ(std::bit_cast<std::uint64_t>(read.samples[0].scans[0].time), std::bit_cast<std::uint64_t>(value));
    if (i == 0) m.samples.resize(1);  // small documents for the rest
  }
}

TEST(Manifest, CannotHoldWhatIsNotFinite) {
  Manifest m = filledManifest();
  m.sensors[0].beams.maxRange = INFINITY;
  EXPECT_THAT(messageOf<Error>([&] { toJson(m); }), HasSubstr("max_range"));
}

// A comment in another encoding must not cost a night's run its manifest.
TEST(Manifest, SurvivesTextThatIsNotUtf8) {
  Manifest m = filledManifest();
  m.pipelineText =
      "# Stra\xDF"
      "e\n";
  EXPECT_EQ(parseManifest(toJson(m), "manifest.json").pipelineText,
            "# Stra\xEF\xBF\xBD"
            "e\n");
}

TEST(Manifest, RefusesEveryMissingKey) {
  const OrderedJson json = OrderedJson::parse(toJson(filledManifest()));
  int tried = 0;
  for (const OrderedJson::json_pointer& place : placesIn(json)) {
    const OrderedJson& parent = json[place.parent_pointer()];
    const std::string path = place.to_string();
    const std::string top = path.substr(0, 8);
    const bool optional = place.back() == "aliases" || place.back() == "origin_left" || place.back() == "origin_up" ||
                          path.starts_with("/about") || place.back() == "scene_file" ||
                          (path.starts_with("/modelled/") && (place.back() == "sensor" || place.back() == "options" ||
                                                              place.back() == "scenes" || place.back() == "parts")) ||
                          (path.starts_with("/sequences/") && place.back() == "vehicle");
    if (!parent.is_object() || top == "/frames/" || optional) continue;
    OrderedJson damaged = json;
    damaged[place.parent_pointer()].erase(place.back());
    const std::string message = refusalOfText(damaged);
    EXPECT_THAT(message, HasSubstr("manifest.json")) << place;
    if (place.back() != "schema_version" && place.back() != "program" && place.to_string() != "/program/name") {
      EXPECT_THAT(message, HasSubstr("'" + place.back() + "' is missing"));
    }
    ++tried;
  }
  EXPECT_GT(tried, 150);
}

TEST(Manifest, RefusesEveryUnknownKey) {
  const OrderedJson json = OrderedJson::parse(toJson(filledManifest()));
  std::vector<OrderedJson::json_pointer> places = placesIn(json);
  places.emplace_back("");
  for (const OrderedJson::json_pointer& place : places) {
    if (!json[place].is_object() || place.to_string() == "/frames") continue;
    EXPECT_THAT(refusalWith(json, place.to_string() + "/colour", 1), HasSubstr("'colour' is unknown")) << place;
  }
}

TEST(Manifest, RefusesEveryWrongType) {
  const OrderedJson json = OrderedJson::parse(toJson(filledManifest()));
  for (const OrderedJson::json_pointer& place : placesIn(json)) {
    for (const OrderedJson& wrong : {OrderedJson(), OrderedJson(true), OrderedJson("x"), OrderedJson::array({nullptr}),
                                     OrderedJson{{"x", 1}}, OrderedJson(-1.5)}) {
      if (wrong.type() == json[place].type()) continue;
      if (wrong.is_number() && json[place].is_number_float()) continue;
      const std::string message = refusalWith(json, place.to_string(), wrong);
      EXPECT_THAT(message, HasSubstr("manifest.json")) << place << " as " << wrong;
    }
  }
}

TEST(Manifest, NamesThePlaceOfWhatIsOutOfRange) {
  const OrderedJson json = OrderedJson::parse(toJson(filledManifest()));
  const std::vector<std::tuple<std::string, OrderedJson, std::string>> damages = {
      {"/samples/1/shard", 2, "2 is out of range: the dataset has 2 shards"},
      {"/samples/1/shard", 0, "0 belongs to 'train', but the sample to 'val'"},
      {"/samples/0/key", "a.b", "'a.b' is not a key"},
      {"/samples/1/key", "street-1-drive-000000", "does not start with the sample's key"},
      {"/samples/0/members/1", "other.csv", "does not start with"},
      {"/samples/0/scans/0/sensor", "left", "no sensor is named 'left'"},
      {"/samples/0/scans/0/world_from_sensor", OrderedJson::array(), "has no pose"},
      {"/samples/0/scans/0/world_from_sensor/0/rotation", {1, 1, 0, 0}, "not a unit quaternion"},
      {"/samples/0/scans/0/world_from_sensor/0/translation", {1, 1}, "2 numbers, but must have 3"},
      {"/samples/0/scans/0/points_per_class/0/id", 8, "class 8 is not in ontology 'ours'"},
      {"/samples/0/scans/0/points_per_class/0/name", "tree", "is 'unlabeled' in the ontology"},
      {"/samples/0/scans/0/points", -1, "/samples/0/scans/0/points: is number, but must be"},
      {"/ontology/classes/1/id", 65536, "65536 is not within 0 to 65535"},
      {"/ontology/classes/1/id", 0, "another item of the list has 0, too"},
      {"/ontology/classes/1/name", "car", "another item of the list has \"car\", too"},
      {"/ontology/classes/1/color", {1, 2}, "has 2 numbers, but must have 3"},
      {"/ontology/classes/1/color/0", 256, "256 is not within 0 to 255"},
      {"/sensors/0/rings", 5, "has 4 numbers, but must have 5"},
      {"/sensors/0/rings", 0, "0 is not within 1"},
      {"/sensors/0/max_range", 0.1, "/sensors/0/max_range"},
      {"/sensors/0/field", 7, "/sensors/0/field"},
      {"/shards/0/file", "../../etc/passwd", "is not a shard of the split 'train'"},
      {"/shards/0/file", "val/val-000000.tar", "is not a shard of the split 'train'"},
      {"/shards/0/sha256", "abc", "not a SHA-256"},
      {"/units/length", "feet", "is not 'metres'"},
      {"/schema_version", 4, "newer than this program, which reads 3: update scanmill"},
      {"/schema_version", 2,
       "/schema_version: 2 is older than this program, which reads 3: make the dataset again with `scanmill generate"},
      {"/program/name", "other", "is not a manifest of scanmill"},
  };
  for (const auto& [place, value, expected] : damages) {
    EXPECT_THAT(refusalWith(json, place, value), HasSubstr(expected)) << place;
  }
  EXPECT_THAT(refusalWith(json, "/samples/1", json["samples"][0]),
              HasSubstr("/samples/1/key: another item of the list has"));
}

TEST(Manifest, SaysWhereATruncatedFileEnds) {
  const std::string text = toJson(filledManifest());
  for (std::size_t i = 0; i < 100; ++i) {
    const std::string cut = text.substr(0, i * (text.size() - 2) / 100);
    const auto lines = std::count(cut.begin(), cut.end(), '\n');
    const std::string message = messageOf<InputError>([&] { parseManifest(cut, "m.json"); });
    EXPECT_THAT(message, HasSubstr("is not complete JSON")) << cut.size();
    EXPECT_THAT(message, HasSubstr("m.json:" + std::to_string(lines + 1) + ":")) << cut.size();
  }
}

TEST(Manifest, RefusesForeignFiles) {
  for (const char* text : {"", "[]", "{}", "null", "\"x\"", "{\"name\": \"app\", \"manifest_version\": 3}", "\xFF\xFE",
                           "1e999", "{\"schema_version\": 1}", "{\"schema_version\": \"1\", \"program\": 3}"}) {
    EXPECT_THAT(messageOf<InputError>([&] { parseManifest(text, "m.json"); }), HasSubstr("m.json")) << text;
  }
  EXPECT_THAT(messageOf<InputError>([] { parseManifest(std::string(1000000, '['), "m.json"); }), HasSubstr("m.json"));
}

TEST(Manifest, AbsentOnesAreExplained) {
  const TemporaryFolder folder;
  EXPECT_THAT(messageOf<InputError>([&] { readManifest(folder.path()); }), HasSubstr("it has no manifest.json"));
  EXPECT_THAT(messageOf<InputError>([&] { readManifest(folder.path() / "absent"); }), HasSubstr("absent"));
  folder.write("manifest.json", toJson(filledManifest()));
  EXPECT_EQ(readManifest(folder.path()).samples.size(), 2u);
}

TEST(ManifestSchema, IsSatisfied) {
  for (const Manifest& manifest : {filledManifest(), testManifest(), manifestWithAllKeys()}) {
    EXPECT_EQ(schemaErrors("manifest", toJson(manifest)), "");
  }
  Manifest wrong = filledManifest();
  wrong.samples[0].key = "a.b";
  EXPECT_NE(schemaErrors("manifest", toJson(wrong)), "");
}

TEST(SampleJson, TellsWhatDiffers) {
  const SampleRecord sample = filledManifest().samples[0];
  const std::string text = sampleJson(sample);
  EXPECT_THAT(differenceOfSampleJson(text, sample), IsEmpty());
  EXPECT_THAT(differenceOfSampleJson(OrderedJson::parse(text).dump(), sample), IsEmpty()) << "blanks do not matter";
  SampleRecord other = sample;
  other.scans[1].points += 1;
  EXPECT_THAT(differenceOfSampleJson(text, other), HasSubstr("/scans/1/points is "));
  other = sample;
  other.scans.pop_back();
  EXPECT_THAT(differenceOfSampleJson(text, other), HasSubstr("/scans has more entries than the manifest says"));
  other = sample;
  other.scans.push_back(sample.scans[0]);
  EXPECT_THAT(differenceOfSampleJson(text, other), HasSubstr("/scans/2 is missing"));
  EXPECT_THAT(differenceOfSampleJson(text.substr(0, 20), sample), HasSubstr("not valid JSON"));
  EXPECT_THAT(differenceOfSampleJson("[]", sample), Not(IsEmpty()));
}

TEST(SampleJson, TakesSequenceAndFrameFromTheKey) {
  const OrderedJson json = OrderedJson::parse(sampleJson(filledManifest().samples[1]));
  EXPECT_EQ(json["sequence"], "street-1-drive");
  EXPECT_EQ(json["frame"], "000001");
  EXPECT_EQ(json["time"], 0.1);
  EXPECT_THAT(partsOfKey("street").sequence, IsEmpty());
  EXPECT_THAT(partsOfKey("street-").sequence, IsEmpty());
  EXPECT_THAT(partsOfKey("street-x1").sequence, IsEmpty());
}

}  // namespace
}  // namespace scanmill
