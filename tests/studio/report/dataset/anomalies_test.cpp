#include "report/dataset/anomalies.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "evaluate/measure.h"
#include "report/dataset/dataset_warnings.h"
#include "tests/core/dataset/fixture.h"
#include "tests/core/methods/trace.h"
#include "tests/support/street.h"
#include "viewer/window/orbit_camera.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

constexpr std::uint16_t kRoad = 1, kBuilding = 6, kWindow = 7, kVegetation = 10, kCar = 20, kBus = 22, kPerson = 30;

// Four streets, each seen from eleven places: what is counted in those scans.
class AnomaliesInStreets : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const auto beams = presetBeams("paper_64");
    manifest_ = std::make_unique<Manifest>();
    counts_ = std::make_unique<std::vector<std::optional<ScanCounts>>>();
    manifest_->columns = {"x", "y", "z", "label", "instance"};
    manifest_->sensors = {{"top", *beams, Pose{}}};
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
      const Scene street = proceduralStreet(seed);
      manifest_->ontology = street.ontology;
      const auto method = rayTracing(street);
      for (int i = 0; i < 11; ++i) {
        const Shot shot = streetShot(beams, -60 + 12 * i);
        const Hits hits = traced(*method, shot, Channel::Range | Channel::Semantic | Channel::Instance);
        Scan scan;
        scan.position = hitPoints(shot, hits);
        for (std::size_t b = 0; b < hits.size(); ++b) {
          if (!hits.hit(b)) continue;
          scan[kLabel].push_back(hits.semantic[b]);
          scan[kInstance].push_back(hits.instance[b]);
        }
        counts_->push_back(countScan(scan, kSteps));
        ScanRecord record = testRecord(manifest_->sensors[0], scan, i);
        manifest_->samples.push_back(
            {"street-s" + std::to_string(seed) + "-lane-" + std::to_string(i), "train", 0, {record}, {}});
      }
    }
  }
  static void TearDownTestSuite() {
    manifest_.reset();
    counts_.reset();
  }

  static DatasetSummary summaryOf(const std::vector<std::optional<ScanCounts>>& counts) {
    return summarise(*manifest_, spreadScans(*manifest_, counts.size()), counts, kSteps);
  }

  // As if whoever labels had taken a thing for another in all scans.
  static DatasetSummary mistaken(const ThingSummary& thing, std::uint16_t wrong) {
    std::vector<std::optional<ScanCounts>> counts = *counts_;
    for (std::size_t k = 0; k < counts.size(); ++k) {
      if (!manifest_->samples[k].key.starts_with(thing.sequence + "-")) continue;
      for (InstanceCounts& seen : counts[k]->instances) {
        if (seen.id != thing.id) continue;
        const std::uint64_t points = seen.pointsOfClass.begin()->second;
        seen.pointsOfClass = {{wrong, points}};
      }
    }
    return summaryOf(counts);
  }

  static std::vector<ThingSummary> wellSeen(const DatasetSummary& summary, std::uint16_t id) {
    std::vector<ThingSummary> things;
    for (const ThingSummary& t : summary.things) {
      if (t.mostClass == id && t.size) things.push_back(t);
    }
    return things;
  }

  // Of so many things, how many are found to be like what they are, when they are called `wrong`.
  static double shareFound(std::uint16_t right, std::uint16_t wrong) {
    const DatasetSummary sound = summaryOf(*counts_);
    double found = 0, all = 0;
    for (const ThingSummary& thing : wellSeen(sound, right)) {
      const DatasetSummary summary = mistaken(thing, wrong);
      for (const Anomaly& anomaly : findAnomalies(summary)) {
        const ThingSummary& named = summary.things[anomaly.thing];
        EXPECT_TRUE(named.sequence == thing.sequence && named.id == thing.id)
            << named.sequence << " " << named.id << " is an anomaly where " << thing.id << " was mistaken";
        found += anomaly.like == right;
      }
      ++all;
    }
    EXPECT_GE(all, 6);
    return found / all;
  }

  static const RangeSteps kSteps;
  static std::unique_ptr<Manifest> manifest_;
  static std::unique_ptr<std::vector<std::optional<ScanCounts>>> counts_;
};

const RangeSteps AnomaliesInStreets::kSteps{1, 122};
std::unique_ptr<Manifest> AnomaliesInStreets::manifest_;
std::unique_ptr<std::vector<std::optional<ScanCounts>>> AnomaliesInStreets::counts_;

TEST_F(AnomaliesInStreets, ThereIsNoneInASoundOne) {
  const DatasetSummary summary = summaryOf(*counts_);
  EXPECT_GT(summary.things.size(), 200u);
  EXPECT_TRUE(findAnomalies(summary).empty());
}

TEST_F(AnomaliesInStreets, SizesTellCarsFromBuildingsAndBuses) {
  EXPECT_GE(shareFound(kCar, kBuilding), 0.8);
  EXPECT_GE(shareFound(kCar, kBus), 0.8);
  EXPECT_GE(shareFound(kBus, kCar), 0.5);
  EXPECT_GE(shareFound(kPerson, kCar), 0.7);
}

TEST_F(AnomaliesInStreets, AThingOfWhatIsNotCountedIsOdd) {
  const DatasetSummary sound = summaryOf(*counts_);
  for (const std::uint16_t stuff : {kVegetation, kRoad}) {
    for (const ThingSummary& thing : wellSeen(sound, kCar)) {
      const DatasetSummary summary = mistaken(thing, stuff);
      const std::vector<Anomaly> anomalies = findAnomalies(summary);
      ASSERT_EQ(anomalies.size(), 1u) << thing.id;
      EXPECT_EQ(summary.things[anomalies[0].thing].id, thing.id);
      EXPECT_FALSE(anomalies[0].like);
    }
  }
}

// Whoever gives all bushes an id means it.
TEST_F(AnomaliesInStreets, ManyThingsOfAClassAreMeant) {
  std::vector<std::optional<ScanCounts>> counts = *counts_;
  for (std::optional<ScanCounts>& c : counts) {
    for (InstanceCounts& seen : c->instances) {
      if (seen.pointsOfClass.contains(kCar)) seen.pointsOfClass = {{kVegetation, seen.pointsOfClass.at(kCar)}};
    }
  }
  EXPECT_TRUE(findAnomalies(summaryOf(counts)).empty());
}

// A part that most things of another class have needs no id of its own to be sound.
TEST_F(AnomaliesInStreets, PartsOfThingsAreNotOdd) {
  std::vector<std::optional<ScanCounts>> counts = *counts_;
  bool alone = false;
  for (std::optional<ScanCounts>& c : counts) {
    for (InstanceCounts& seen : c->instances) {
      if (!seen.pointsOfClass.contains(kCar) || seen.pointsOfClass.at(kCar) < 2) continue;
      if (!alone) {
        seen.pointsOfClass = {{kWindow, seen.pointsOfClass.at(kCar)}};  // one of which but a window is seen
        alone = true;
      } else {
        --seen.pointsOfClass.at(kCar);
        seen.pointsOfClass[kWindow] = 1;
      }
    }
  }
  ASSERT_TRUE(alone);
  EXPECT_TRUE(findAnomalies(summaryOf(counts)).empty());
}

TEST_F(AnomaliesInStreets, WarningsNameTheThingAndShowIt) {
  const DatasetSummary sound = summaryOf(*counts_);
  std::vector<ThingSummary> cars = wellSeen(sound, kCar);
  std::erase_if(cars, [](const ThingSummary& t) { return t.size->height > 1.6 || t.size->length > 5; });  // vans
  ASSERT_FALSE(cars.empty());
  const ThingSummary& car =
      *std::ranges::max_element(cars, [](const auto& a, const auto& b) { return a.points < b.points; });
  const auto warningFor = [&](std::uint16_t wrong) {
    const DatasetSummary summary = mistaken(car, wrong);
    for (const DatasetWarning& w : warningsOf(summary, {}, "my data")) {
      if (!w.command.empty()) return w;
    }
    return DatasetWarning{"no warning"};
  };
  const DatasetWarning size = warningFor(kBuilding), id = warningFor(kVegetation);
  EXPECT_THAT(size.text, HasSubstr(fmt::format("building {} of {} is {:.1f} x {:.1f} x {:.1f} m, like car (", car.id,
                                               car.sequence, car.size->length, car.size->width, car.size->height)));
  EXPECT_THAT(id.text, HasSubstr(fmt::format("vegetation: instance {} of {} ({} scans, {} points) has an instance id, "
                                             "which no other vegetation has",
                                             car.id, car.sequence, car.scans, car.points)));
  EXPECT_EQ(size.command, id.command);
  EXPECT_TRUE(size.command.starts_with("scanmill view 'my data' --sample " + car.bestSample + " --camera="));
  EXPECT_TRUE(size.command.ends_with(fmt::format(" --instance {}", car.id)));
  EXPECT_FALSE(size.note);
  // The camera sees the whole of it, as a good part of the picture.
  const std::size_t from = size.command.find("--camera=") + 9;
  const ViewCamera camera =
      parseCamera(size.command.substr(from, size.command.find(' ', from) - from)).camera.camera(1600, 900);
  double low = 1e9, high = -1e9;
  for (int corner = 0; corner < 8; ++corner) {
    const Box& b = car.bestBox;
    const Projected p = camera.project(
        {corner & 1 ? b.high.x : b.low.x, corner & 2 ? b.high.y : b.low.y, corner & 4 ? b.high.z : b.low.z});
    EXPECT_TRUE(p.x > 0 && p.x < 1600 && p.y > 0 && p.y < 900) << p.x << " " << p.y;
    low = std::min(low, p.x);
    high = std::max(high, p.x);
  }
  EXPECT_GT(high - low, 150);
}

TEST(ViewCommand, NamesTheSensorWhereThereAreSeveral) {
  ThingSummary thing{"a-s1-b", 7};
  thing.bestSample = "a-s1-b-000003";
  thing.bestSensor = "Rear left";
  thing.bestBox.add(Vec3d{10, 10, -1});
  thing.bestBox.add(Vec3d{11, 11, 0});
  EXPECT_THAT(viewCommand("out/it's", thing, true),
              testing::StartsWith("scanmill view 'out/it'\\''s' --sample a-s1-b-000003 --sensor 'Rear left' --cam"));
  EXPECT_THAT(viewCommand("out/x", thing, false),
              HasSubstr("scanmill view out/x --sample a-s1-b-000003 --camera=45,20,"));
}

}  // namespace
}  // namespace scanmill
