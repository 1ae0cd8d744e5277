// The law of round trips: what is exported or written comes back with every column that the layout or format can hold.

#include <fmt/format.h>

#include <ostream>
#include <set>

#include "dataset/scan_store.h"
#include "formats/format.h"
#include "tests/core/exports/export_world.h"

namespace scanmill {
namespace {

struct Trip {
  const char* name;                              // of a layout or a format
  const char* labels;                            // classes of the layout, see ExportWorld::use()
  double place = 0;                              // m, largest error of a position
  double intensity = 0;                          // largest error
  double others = 0;                             // largest error of other columns of floats
  bool renumbered = false;                       // true: instances have other numbers
  std::set<std::string> held = {};               // columns that come back; empty: all but `lost`
  std::map<std::string, const char*> lost = {};  // columns that do not come back, and why
};

void PrintTo(const Trip& trip, std::ostream* out) {
  *out << trip.name;
}

// Columns that a layout has no place for are those that `held` does not name.
const Trip kTrips[] = {
    {.name = "pcd", .labels = ""},
    {.name = "csv", .labels = ""},
    {.name = "draco",
     .labels = "",
     .place = 1.1e-3,
     .others = 1.1e-3,
     .lost = {{"time", "follows from ring and column; `time: true` keeps it"}}},
    {.name = "las",
     .labels = "cityscapes",
     .place = 5e-4,
     .lost = {{"time", "is added to that of the scan: gps_time, seconds since the start of the sequence"}}},
    {.name = "ply", .labels = "cityscapes"},
    {.name = "kitti", .labels = "kitti", .held = {"intensity"}},
    {.name = "semantic_kitti", .labels = "semantic_kitti", .held = {"intensity", "label", "instance"}},
    {.name = "nuscenes",
     .labels = "nuscenes",
     .intensity = 0.51 / 255,
     .renumbered = true,
     .held = {"intensity", "label", "instance", "ring"}},
};

class RoundTrip : public ExportWorld, public testing::WithParamInterface<Trip> {
 protected:
  void SetUp() override {
    use(trip_.labels);
    plan_.manifest.columns = {"x", "y", "z"};
    for (const Column& column : kColumns) plan_.manifest.columns.emplace_back(column.name);
    if (std::string(trip_.name) != "las") return;
    plan_.sequences.clear();  // a file has all frames of a sequence: one frame each
    for (std::size_t k = 0; k < 4; ++k) {
      const SampleRecord& sample = plan_.manifest.samples[k];
      plan_.sequences.push_back({sample.key, sample.split, {k}});
    }
  }

  // Fills all columns of the table that the scan lacks.
  void complete(Scan& scan) const {
    const std::uint16_t car = classId("car");
    visitTable(scan, [&]<class T>(auto key, std::vector<T>& values) {
      for (std::size_t i = values.size(); i < scan.size(); ++i) {
        if constexpr (std::is_same_v<T, float>) {
          values.push_back(static_cast<float>(i % 100) / 100);
        } else {
          const std::string_view name = key.row.name;
          values.push_back(static_cast<T>(name == "label_2"   ? car
                                          : name == "returns" ? 3
                                          : name == "cause"   ? 1  // LAS withholds others, which readers leave out
                                                              : 1 + i % 3));
        }
      }
    });
  }

  Scan own(std::size_t sample) const {
    Scan own = scan(0, sample % 2);
    complete(own);
    return own;
  }

  // `change` changes the scan of a sample.
  template <class Change>
  void write(const Change& change) const {
    const auto isNamed = [&](const auto& entry) { return entry.name == trip_.name; };
    if (std::any_of(formats().begin(), formats().end(), isNamed)) {
      const Value none;
      Fields options(none, "format");
      const FormatEntry& entry = requireFormat(trip_.name, {});
      const auto format = entry.make(options);
      for (std::size_t k = 0; k < 4; ++k) {
        Scan scan = this->scan(0, k % 2);
        change(scan);
        folder_.write(fmt::format("{}.{}", k, entry.suffix), format->encode(scan));
      }
      return;
    }
    const auto layout = requireLayout(trip_.name).make();
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t frames = plan_.sequences.front().samples.size();
      writeChanged(*layout, k / frames, k % frames, [&](ExportSample& changed) {
        changed.scans[0].scan = this->scan(0, k % 2);
        change(changed.scans[0].scan);
      });
    }
    layout->finish(
        plan_, [&](std::size_t s, std::size_t f) { return std::optional(objects(s, f)); },
        ExportFolder(folder_.path()));
  }

  // Returns the point's place in the frame of the sensor.
  Vec3d placeOf(const Scan& read, std::size_t point, std::size_t sample) const {
    const Vec3d p(read.position[point]);
    const std::string name = trip_.name;
    if (name == "nuscenes") return {p.y, -p.x, p.z};
    if (name != "las") return p;
    return inverse(plan_.manifest.samples[sample].scans[0].worldFromSensor.front()) * p;
  }

  bool isHeld(const std::string& column) const {
    return trip_.held.empty() ? !trip_.lost.contains(column) : trip_.held.contains(column);
  }

  const Trip& trip_ = GetParam();
};

TEST_P(RoundTrip, EveryColumnThatFitsComesBack) {
  write([&](Scan& scan) { complete(scan); });
  const ScanStore store(folder_.path());
  ASSERT_EQ(store.keys().size(), 4u);
  for (std::size_t sample = 0; sample < 4; ++sample) {
    SCOPED_TRACE(store.keys()[sample]);
    const Scan read = store.decode(sample, store.scans(sample).front());
    const Scan own = this->own(sample);
    ASSERT_EQ(read.size(), own.size());
    std::vector<std::size_t> from;  // index of each point in `own`
    for (std::size_t i = 0; i < read.size(); ++i) {
      std::size_t nearest = 0;
      const auto distance = [&](std::size_t k) { return length(placeOf(read, i, sample) - Vec3d(own.position[k])); };
      for (std::size_t k = 1; k < own.size(); ++k) nearest = distance(k) < distance(nearest) ? k : nearest;
      ASSERT_LE(distance(nearest), trip_.place);
      from.push_back(nearest);
    }
    std::map<std::uint32_t, std::uint32_t> numbers;  // by the numbers of `own`
    visitTable(own, [&]<class T>(auto key, const std::vector<T>& values) {
      const std::string name(key.row.name);
      SCOPED_TRACE(name);
      ASSERT_EQ(read[key].empty(), !isHeld(name));
      if (!isHeld(name)) return;
      ASSERT_EQ(read[key].size(), read.size());
      for (std::size_t i = 0; i < read.size(); ++i) {
        const T value = values[from[i]];
        const T found = read[key][i];
        if constexpr (std::is_same_v<T, float>) {
          ASSERT_NEAR(trip_.name == std::string("nuscenes") ? found / 255 : found, value,
                      name == "intensity" ? trip_.intensity : trip_.others);
        } else if (key.row.display.colors == ColumnColors::Classes) {
          const SemanticClass* const c = plan_.classes.target().find(static_cast<std::uint16_t>(found));
          ASSERT_NE(c, nullptr);
          ASSERT_EQ(c->movingOf.value_or(c->id), plan_.classes.targetId(static_cast<std::uint16_t>(value)));
        } else if (name == "instance" && trip_.renumbered) {
          ASSERT_EQ(numbers.try_emplace(value, found).first->second, found);
          ASSERT_EQ(value == 0, found == 0);
        } else {
          ASSERT_EQ(found, value);
        }
      }
    });
    ASSERT_EQ(numbers.size(), trip_.renumbered ? 3u : 0u) << "none, the car and the pedestrian";
  }
}

TEST_P(RoundTrip, ScansWithoutPointsKeepTheirColumns) {
  if (!trip_.held.empty()) return;  // without points such a file is empty
  write([](Scan& scan) {
    scan = Scan();
    scan.columnsIfEmpty = ColumnSet::all();
  });
  const ScanStore store(folder_.path());
  const Scan read = store.decode(0, store.scans(0).front());
  EXPECT_EQ(read.size(), 0u);
  forEachColumn([&](auto key) { EXPECT_EQ(read.has(key), isHeld(std::string(key.row.name))) << key.row.name; });
}

TEST_P(RoundTrip, ScansWithoutColumnsKeepTheirPoints) {
  if (!trip_.held.empty()) return;  // such a file has columns of its own
  write([](Scan& scan) { visitTable(scan, [](auto, auto& values) { values.clear(); }); });
  const ScanStore store(folder_.path());
  EXPECT_EQ(store.decode(0, store.scans(0).front()).size(), 308u);
}

INSTANTIATE_TEST_SUITE_P(ReadBack, RoundTrip, testing::ValuesIn(kTrips),
                         [](const testing::TestParamInfo<Trip>& trip) { return std::string(trip.param.name); });

}  // namespace
}  // namespace scanmill
