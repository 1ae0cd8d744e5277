#include "dataset/objects.h"

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "tests/core/dataset/fixture.h"
#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

using OrderedJson = nlohmann::ordered_json;
using testing::HasSubstr;

SampleObjects someObjects() {
  SampleObjects sample{"yard-s1-drive-000003", 0.3, {}};
  ObjectRecord car;
  car.id = 7;
  car.semantic = 2;
  car.name = "car \"7\"";
  car.parts = {"body", "wheels"};
  car.moves = true;
  car.worldFromBox = {fromYawPitchRoll(0.3, 0.01, 0), {4'000'123.45678, -17, 0.75}};
  car.size = {4.2, 1.8, 1.5};
  car.velocity = {8.123456, 0, -0.00001};
  ObjectView view;
  view.sensor = "top";
  view.time = 0.3123456;
  view.sensorFromBox = {fromYawPitchRoll(-1, 0, 0), {12, -3, -1}};
  view.points = 120;
  view.beams = 90;
  view.beamsAlone = 130;
  view.truncation = 0.25;
  view.nearestRange = 11.25;
  car.views = {view};
  view.sensor = "rear";
  view.points = view.beams = view.beamsAlone = 0;
  view.nearestRange.reset();
  car.views.push_back(view);
  sample.objects = {car};
  car.id = 9;
  car.parts = {};
  car.views.resize(1);
  car.views[0].points = 0;
  sample.objects.push_back(car);
  return sample;
}

TEST(Objects, ComeBackAsTheyWere) {
  const SampleObjects sample = someObjects();
  const std::string text = objectsJson(sample, testOntology());
  const SampleObjects read = parseObjects(text, "a", testOntology());
  EXPECT_EQ(objectsJson(read, testOntology()), text);
  ASSERT_EQ(read.objects.size(), 2u);
  const ObjectRecord& car = read.objects[0];
  EXPECT_EQ(car.name, "car \"7\"");
  EXPECT_EQ(car.parts, sample.objects[0].parts);
  EXPECT_NEAR(length(car.worldFromBox.translation - sample.objects[0].worldFromBox.translation), 0, 1e-4);
  EXPECT_NEAR(std::abs(car.worldFromBox.rotation.w - sample.objects[0].worldFromBox.rotation.w), 0, 1e-9);
  EXPECT_NEAR(*car.views[0].visibility(), 90.0 / 130, 1e-12);
  EXPECT_EQ(car.views[1].visibility(), std::nullopt);
  EXPECT_FALSE(car.views[1].nearestRange.has_value());
  EXPECT_EQ(read.counts(), (std::map<std::uint16_t, ObjectCount>{{2, {2, 1}}}));
}

TEST(Objects, WhatIsMissingUnknownOrWrongIsNamed) {
  const OrderedJson whole = OrderedJson::parse(objectsJson(someObjects(), testOntology()));
  const auto refusal = [&](const OrderedJson& json) {
    return messageOf<InputError>([&] { parseObjects(json.dump(), "list.json", testOntology()); });
  };
  for (const char* place : {"/key", "/objects/0/id", "/objects/1/size", "/objects/0/views/1/beams",
                            "/objects/0/views/0/nearest_range", "/objects/0/world_from_box/rotation"}) {
    OrderedJson without = whole.flatten().unflatten();
    const OrderedJson::json_pointer pointer(place);
    without[pointer.parent_pointer()].erase(pointer.back());
    EXPECT_THAT(refusal(without),
                testing::AllOf(HasSubstr("list.json"), HasSubstr(pointer.back()), HasSubstr("missing")));
  }
  const auto with = [&](const char* place, const OrderedJson& value) {
    OrderedJson changed = whole;
    changed[OrderedJson::json_pointer(place)] = value;
    return refusal(changed);
  };
  EXPECT_THAT(with("/objects/1/id", 7), HasSubstr("/objects/1/id: another item"));
  EXPECT_THAT(with("/objects/1/id", 0), HasSubstr("/objects/1/id"));
  EXPECT_THAT(with("/objects/0/class", 99), HasSubstr("class 99 is not in ontology 'test'"));
  EXPECT_THAT(with("/objects/0/class_name", "dog"), HasSubstr("class 2 is 'thing'"));
  EXPECT_THAT(with("/objects/0/views/0/visibility", 1), HasSubstr("is not beams / beams_alone"));
  EXPECT_THAT(with("/objects/0/views/0/visibility", nullptr), HasSubstr("is not beams / beams_alone"));
  EXPECT_THAT(with("/objects/0/views/1/sensor", "top"), HasSubstr("/views/1/sensor: another item"));
  EXPECT_THAT(with("/objects/0/size", {1, -1, 1}), HasSubstr("/size/1: -1 is not within 0"));
  EXPECT_THAT(with("/objects/0/world_from_box/rotation", {1, 1, 0, 0}), HasSubstr("unit quaternion"));
  EXPECT_THAT(with("/objects/0/colour", "red"), HasSubstr("unknown"));
}

TEST(Objects, SatisfyTheSchema) {
  const std::string text = objectsJson(someObjects(), testOntology());
  EXPECT_EQ(schemaErrors("objects", text), "");
  OrderedJson wrong = OrderedJson::parse(text);
  wrong["objects"][0]["views"][0]["visibility"] = 2;
  EXPECT_NE(schemaErrors("objects", wrong.dump()), "");
  wrong = OrderedJson::parse(text);
  wrong["objects"][0].erase("velocity");
  EXPECT_NE(schemaErrors("objects", wrong.dump()), "");
}

}  // namespace
}  // namespace scanmill
