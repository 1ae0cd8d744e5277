#include "methods/particle/field_backend.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "methods/field/build.h"
#include "methods/field/same_field.h"
#include "tests/core/methods/field/triangle_soup.h"
#include "tests/support/gl.h"

namespace scanmill {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::StartsWith;

struct Soup {
  Scene scene = sceneOf(soup(60, 3, 0.003, 5));
  std::shared_ptr<const World> world = worldOf(scene);
  FieldShape at(double x) const { return shapeAt({x, 0, 0}, 0.1, 32, 3, true); }
};

TEST(FieldBackend, WithoutADeviceTheProcessorBuilds) {
  const Soup soup;
  FieldBackend backend(nullptr);
  EXPECT_TRUE(sameField(*backend.build(soup.world, soup.at(0), {}), *buildField(*soup.world, soup.at(0))));
  EXPECT_EQ(backend.outcome(true), "");
}

// Whoever is faster: the field is the same.
TEST(FieldBackend, MeasuresOnce) {
  SKIP_WITHOUT_GL();
  const Soup soup;
  auto device = std::make_unique<DeviceBricks>();
  const std::string name = device->device();
  FieldBackend backend(std::move(device));
  EXPECT_EQ(backend.outcome(true), "");
  auto field = backend.build(soup.world, soup.at(0), {});
  const std::string outcome = backend.outcome(true);
  EXPECT_THAT(outcome, AnyOf(StartsWith(name), StartsWith("the processor (")));
  EXPECT_THAT(outcome, HasSubstr(" ms a field; "));
  for (int step = 1; step < 5; ++step) {
    field = backend.build(soup.world, soup.at(0.5 * step), {field});
    EXPECT_TRUE(sameField(*field, *buildField(*soup.world, soup.at(0.5 * step))));
  }
  EXPECT_EQ(backend.outcome(true), outcome);
}

// A place far from everything says nothing of the device.
TEST(FieldBackend, FieldsWithoutBricksDecideNothing) {
  SKIP_WITHOUT_GL();
  const Soup soup;
  FieldBackend backend(std::make_unique<DeviceBricks>());
  EXPECT_TRUE(sameField(*backend.build(soup.world, soup.at(500), {}), *buildField(*soup.world, soup.at(500))));
  EXPECT_EQ(backend.outcome(true), "");
  backend.build(soup.world, soup.at(0), {});
  EXPECT_THAT(backend.outcome(true), HasSubstr(" ms a field; "));
  EXPECT_EQ(backend.outcome(false), "") << "those without lists are another matter";
}

TEST(FieldBackend, ADeviceThatHoldsTooLittleIsNotTaken) {
  SKIP_WITHOUT_GL();
  const Soup soup;
  for (const std::uint64_t bytes : {1000u, 9000u}) {  // too few for the scene, and for its lists
    FieldBackend backend(std::make_unique<DeviceBricks>(bytes));
    EXPECT_TRUE(sameField(*backend.build(soup.world, soup.at(0), {}), *buildField(*soup.world, soup.at(0))));
    EXPECT_THAT(backend.outcome(true), StartsWith("the processor, since "));
  }
}

}  // namespace
}  // namespace scanmill
