#include "pipeline/checks/heading_warnings.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include "scenefile/concepts.h"

namespace scanmill {

namespace {

// A box points sideways if its width exceeds kWider times its length. Models that are about square may face either way.
constexpr double kWider = 1.1;
constexpr double kDriving = 0.5;   // minimum speed of vehicles whose heading is checked (m/s)
constexpr double kAhead = 0.7071;  // cosine of 45 degrees: the largest angle between the velocity and the box's x axis
constexpr std::size_t kMostHeadings = 5;
// Times at which velocities are checked (s). A vehicle may stand still at first and drive later.
constexpr double kTimes[] = {0, 1, 3, 10};

bool drivesSideways(const ThingBoxes& boxes, std::size_t thing) {
  return std::any_of(std::begin(kTimes), std::end(kTimes), [&](double time) {
    const Vec3d velocity = boxes.velocity(thing, time);
    const double speed = length(velocity);
    const Vec3d ahead = toMatrix(boxes.at(thing, time).worldFromBox.rotation).x;
    return speed > kDriving && std::fabs(dot(velocity, ahead)) < kAhead * speed;
  });
}

}  // namespace

std::vector<std::string> headingWarnings(const Scene& scene, const ThingBoxes& boxes) {
  static const std::vector<Concept> concepts = knownConcepts();
  const std::set<std::uint16_t> wheels = classesWithWheels(concepts, scene.ontology);
  std::set<std::string> told;
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < boxes.things().size(); ++i) {
    const Thing& thing = boxes.things()[i];
    if (!thing.headingKnown || !wheels.contains(thing.semantic)) continue;
    const Vec3d size = boxes.at(i, 0).size;
    const bool isAcross = size.y > kWider * size.x;
    if (!isAcross && !(thing.moves && drivesSideways(boxes, i))) continue;
    const std::string name = thing.name.substr(0, thing.name.find('#'));
    if (!told.insert(name).second) continue;
    const std::string what =
        isAcross ? fmt::format("is {:.3g} m wide and {:.3g} m long", size.y, size.x) : std::string("drives sideways");
    lines.push_back(
        fmt::format("scene {}: '{}', a {}, {}: boxes point along its x axis; `facing: -y`, or whichever way "
                    "its model looks, turns them (`scanmill view SCENE --contact-sheet` shows them)",
                    scene.name, name, scene.ontology.find(thing.semantic)->name, what));
  }
  if (lines.size() > kMostHeadings) {
    const std::size_t more = lines.size() - kMostHeadings;
    lines.resize(kMostHeadings);
    lines.push_back(fmt::format("scene {}: {} more models have boxes that point sideways", scene.name, more));
  }
  return lines;
}

}  // namespace scanmill
