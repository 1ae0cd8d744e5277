#include "pipeline/checks/warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "scenefile/scene_file.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class HeadingWarnings : public testing::Test {
 protected:
  // Of objects on a plane, a line each.
  std::vector<std::string> of(const std::string& objects) const {
    const std::string labels = SCANMILL_SOURCE_DIR "/labels/";
    const auto file = folder_.write("yard.yaml", "ontology: " + labels + "scanmill.yaml\nmaterials: " + labels +
                                                     "materials.yaml\nobjects:\n" + objects);
    const Scene scene = readScene(file, {});
    return headingWarnings(scene, ThingBoxes(scene));
  }

  TemporaryFolder folder_;
};

constexpr const char* kAcross =
    "  - {name: truck, primitive: box, size: [2, 5, 3], class: truck, material: car_paint, position: [9, 0, 1.5]";

TEST_F(HeadingWarnings, TellOfVehiclesThatAreWiderThanLong) {
  EXPECT_THAT(
      of(std::string(kAcross) + "}\n"),
      ElementsAre(AllOf(HasSubstr("scene yard: 'truck', a truck, is 5 m wide and 2 m long"), HasSubstr("facing"))));
  EXPECT_THAT(of(std::string(kAcross) + ", facing: -y}\n"), IsEmpty());
  // Nobody minds which way a box, or a square car, looks.
  EXPECT_THAT(of("  - {primitive: box, size: [2, 5, 3], class: object, material: metal_bare}\n"
                 "  - {primitive: box, size: [2, 2, 1], class: car, material: car_paint, position: [9, 0, 0]}\n"),
              IsEmpty());
}

TEST_F(HeadingWarnings, TellOfVehiclesThatDriveSideways) {
  const std::string car =
      "  - {name: car, primitive: box, size: [4, 2, 1.5], class: car, material: car_paint, moving: {velocity: ";
  EXPECT_THAT(of(car + "[5, 1, 0]}}\n"), IsEmpty());
  EXPECT_THAT(of(car + "[-5, 0, 0]}}\n"), IsEmpty()) << "backwards";
  EXPECT_THAT(of(car + "[1, 5, 0]}}\n"), ElementsAre(HasSubstr("'car', a car, drives sideways")));
}

TEST_F(HeadingWarnings, NameEachModelOnceAndTheFirstFew) {
  std::string all;
  for (int i = 0; i < 8; ++i) {
    std::string line = std::string(kAcross) + "}\n";
    all += line.replace(line.find("truck"), 5, "truck" + std::to_string(i))
               .replace(line.find("[9,"), 3, "[" + std::to_string(9 * i) + ",");
  }
  EXPECT_THAT(of(all), AllOf(SizeIs(6), testing::Contains(HasSubstr("3 more"))));
}

}  // namespace
}  // namespace scanmill
