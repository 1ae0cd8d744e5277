#include <cstring>

#include "exports/nuscenes_names.h"
#include "tests/core/exports/nuscenes_world.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class NuScenesLayout : public NuScenesWorld {
 protected:
  // Moves the points of each object into its box.
  static void fillBoxes(ExportSample& sample) {
    Scan& scan = sample.scans.front().scan;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      for (const ObjectRecord& object : sample.objects->objects) {
        if (scan[kInstance][i] != object.id) continue;
        const auto inside = [&](std::size_t step) { return 0.98 * (static_cast<double>(i * step % 101) / 100 - 0.5); };
        const Vec3d& size = object.size;
        const Vec3d p{size.x * inside(7), size.y * inside(13), size.z * inside(29)};
        scan.position[i] = static_cast<Vec3f>(object.views.front().sensorFromBox * p);
      }
    }
  }

  std::string bytesOf(const std::filesystem::path& file) const { return readFile(folder_.path() / file); }
  std::string firstPoints() const {
    const SampleRecord& first = plan_.manifest.samples[0];
    return bytesOf(pointsFile(plan_, 0, first, 0, first.scans[0]));
  }

  static std::string listOf(const std::vector<Vec3d>& points) {
    std::string text;
    for (const Vec3d& p : points) text += fmt::format("[{}, {}, {}], ", p.x, p.y, p.z);
    return "np.array([" + text + "])";
  }
};

// Through calibrated_sensor and ego_pose, points are where the sensor saw them in the world; in the file the x axis
// points to the right and y forward, as the sensor of nuScenes has it.
TEST_F(NuScenesLayout, PointsComeBackThroughTheCalibration) {
  write(*layout_);
  const Scan own = scan(0, 1);
  std::vector<Vec3d> inSensor;
  std::vector<Vec3d> inWorld;
  for (const Vec3f& p : own.position) {
    inSensor.push_back(static_cast<Vec3d>(p));
    inWorld.push_back(plan_.manifest.samples[1].scans[0].worldFromSensor[0] * inSensor.back());
  }
  readTables("sensor = " + listOf(inSensor) + "\nworld = " + listOf(inWorld) + R"(
data = lidar_data[1]
points = points_of(data)
assert len(points) == 308
assert np.array_equal(points[:, 0], -sensor[:, 1].astype(np.float32))
assert np.array_equal(points[:, 1], sensor[:, 0].astype(np.float32))
assert np.array_equal(points[:, 2], sensor[:, 2].astype(np.float32))
ego, calibration = ego_and_sensor(data)
own = np.c_[points[:, :3], np.ones(len(points))] @ (ego @ calibration).T
assert np.abs(own[:, :3] - world).max() < 1e-5
# As of the real car, which has the sensor's x axis to its right: here it is turned to the left by 0.1 rad more.
assert np.allclose(calibration[:3, 0], [np.sin(0.1), -np.cos(0.1), 0])
assert np.allclose(calibration[:3, 1], [np.cos(0.1), np.sin(0.1), 0])
assert np.allclose(calibration[:3, 3], [1.2, 0, 1.9])
)");
}

// Every lidar has a channel with its own calibration, points and labels; boxes count the points of all of them.
TEST_F(NuScenesLayout, EveryLidarIsAChannel) {
  useBothSensors();
  EXPECT_THAT(write(*layout_), testing::Not(testing::Contains(HasSubstr("deskew"))));
  std::string worlds;
  for (const std::size_t sensor : {0u, 1u}) {
    std::vector<Vec3d> inWorld;
    for (const Vec3f& p : scan(sensor, 1).position) {
      inWorld.push_back(plan_.manifest.samples[1].scans[sensor].worldFromSensor[0] * static_cast<Vec3d>(p));
    }
    worlds += (sensor == 0 ? "world = {'LIDAR_TOP': " : "'LIDAR_REAR': ") + listOf(inWorld) + ", ";
  }
  readTables(worlds + "}" + R"(
assert [row['channel'] for row in table['sensor'] if row['modality'] == 'lidar'] == ['LIDAR_TOP', 'LIDAR_REAR']
assert len(lidar_data) == 2 * len(table['sample']) == len(table['ego_pose']) == len(table['panoptic'])
for number, sample in enumerate(table['sample']):
    lidars = {channel: token for channel, token in sample['data'].items() if channel.startswith('LIDAR')}
    assert set(lidars) == {'LIDAR_TOP', 'LIDAR_REAR'}
    for channel, token in lidars.items():
        data = get('sample_data', token)
        assert data['filename'].startswith('samples/%s/' % channel)
        points = points_of(data)
        assert len(points) == len(lidarseg_of(data)) == len(panoptic_of(data)) == 308
        if number != 1: continue
        ego, calibration = ego_and_sensor(data)
        own = np.c_[points[:, :3], np.ones(len(points))] @ (ego @ calibration).T
        assert np.abs(own[:, :3] - world[channel]).max() < 1e-5, channel
        before = get('sample_data', data['prev'])
        assert before['calibrated_sensor_token'] == data['calibrated_sensor_token']
for a in table['sample_annotation']:
    assert a['num_lidar_pts'] in (2 * 72, 2 * 60)
)");
}

// A sensor that turns twice as fast as the other has a key frame and a sweep in each sample, in one chain.
TEST_F(NuScenesLayout, FurtherRevolutionsAreSweeps) {
  useBothSensors();
  for (SampleRecord& sample : plan_.manifest.samples) {
    sample.scans.push_back(sample.scans[1]);
    sample.scans.back().revolution = 1;
    sample.scans.back().time += 0.05;
    sample.scans.back().worldFromSensor[0].translation.x += 0.25;
  }
  write(*layout_);
  readTables(R"(
assert len(table['lidarseg']) == len(table['panoptic']) == 2 * len(table['sample'])
for scene in table['scene']:
    data = get('sample_data', get('sample', scene['first_sample_token'])['data']['LIDAR_REAR'])
    chain = [data]
    while data['next']:
        assert get('sample_data', data['next'])['prev'] == data['token']
        data = get('sample_data', data['next'])
        chain.append(data)
    assert [d['is_key_frame'] for d in chain] == [True, False, True, False]
    assert all(b['timestamp'] - a['timestamp'] == 50000 for a, b in zip(chain, chain[1:]))
    for d in chain:
        assert d['filename'].startswith(('samples' if d['is_key_frame'] else 'sweeps') + '/LIDAR_REAR/')
        assert len(points_of(d)) == 308 and get('ego_pose', d['ego_pose_token'])['timestamp'] == d['timestamp']
    x = [get('ego_pose', d['ego_pose_token'])['translation'][0] for d in chain]
    assert np.allclose(np.diff(x), 0.25)
    assert get('sample_data', get('sample', scene['last_sample_token'])['data']['LIDAR_TOP'])['next'] == ''
)");
  plan_.manifest.samples[1].scans.erase(plan_.manifest.samples[1].scans.begin() + 1,
                                        plan_.manifest.samples[1].scans.end());
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }), HasSubstr("has no scan of the sensor 'rear'"));
}

TEST_F(NuScenesLayout, SensorsOfOneChannelAreRefused) {
  useBothSensors();
  SensorRecord third = plan_.manifest.sensors[1];
  for (const char* name : {"re-ar", "re_ar"}) {
    nameSensor(name[2] == '-' ? 0 : 1, name);
  }
  third.name = "top";
  for (SampleRecord& sample : plan_.manifest.samples) {
    sample.scans.push_back(sample.scans[0]);
    sample.scans.back().sensor = "top";
  }
  plan_.sensors = {&third, &plan_.manifest.sensors[0]};
  EXPECT_NO_THROW(layout_->check(plan_));
  plan_.sensors.push_back(&plan_.manifest.sensors[1]);
  EXPECT_THAT(messageOf<InputError>([&] { layout_->check(plan_); }),
              testing::AllOf(HasSubstr("'re-ar' and 're_ar'"), HasSubstr("LIDAR_RE_AR"), HasSubstr("--sensor")));
}

// A scene has the mount of its sequence, and the vehicle stands where it stood.
TEST_F(NuScenesLayout, MountsMayDifferFromSequenceToSequence) {
  for (SampleRecord& sample : plan_.manifest.samples) sample.scans[0].vehicleFromSensor = Pose{{}, {0, 0, 1.5}};
  write(*layout_);
  const Vec3d& at = plan_.manifest.samples[1].scans[0].worldFromSensor[0].translation;
  readTables("at = " + listOf({at}) + R"(
assert len(table['calibrated_sensor']) == 7 * len(table['scene'])
ego, calibration = ego_and_sensor(lidar_data[1])
assert np.allclose(calibration[:3, 3], [0, 0, 1.5])
assert np.abs((ego @ calibration)[:3, 3] - at[0]).max() < 1e-9
)");
}

TEST_F(NuScenesLayout, IntensitiesAreBytesAndRingsCountFromBelow) {
  SensorRecord& sensor = plan_.manifest.sensors[0];
  sensor.beams.elevation = {0.2, 0.1, -0.3, 0.0};
  const auto change = [](ExportSample& changed) {
    std::vector<float>& intensity = changed.scans[0].scan[kIntensity];
    intensity[0] = 0.5f;
    intensity[1] = 1.5f;
    intensity[2] = -0.1f;
    intensity[3] = std::numeric_limits<float>::quiet_NaN();
  };
  writeChanged(*layout_, 0, 0, change);
  const std::string bytes = firstPoints();
  const Scan own = scan(0, 0);
  ASSERT_EQ(bytes.size(), own.size() * 20);
  const float wanted[] = {128, 255, 0, 0};  // 127.5 is rounded
  const float fromBelow[] = {3, 2, 0, 1};
  for (std::size_t i = 0; i < own.size(); ++i) {
    float values[5];
    std::memcpy(values, bytes.data() + 20 * i, 20);
    ASSERT_EQ(values[3], i < 4 ? wanted[i] : std::round(255 * own[kIntensity][i]));
    ASSERT_EQ(values[4], fromBelow[own[kRing][i]]);
  }
}

// What get_sample_data() gives, against the points themselves. Where the box is at the sample's time does not matter,
// nor what other sensors see of it.
TEST_F(NuScenesLayout, BoxesHoldTheirPointsAndNoOthers) {
  write(*layout_);
  for (const std::size_t s : {0u, 1u}) {
    for (const std::size_t f : {0u, 1u}) writeChanged(*layout_, s, f, fillBoxes);
  }
  layout_->finish(
      plan_,
      [&](std::size_t s, std::size_t f) {
        SampleObjects all = objects(s, f);
        for (ObjectRecord& object : all.objects) {
          object.worldFromBox.translation.x += 30;
          object.views.insert(object.views.begin(), ObjectView{"rear", 0, {}, 5, 1, 100});
        }
        return std::optional(all);
      },
      folder());
  const std::string printed = readTables(R"(
boxes = 0
for data in lidar_data:
    points, label = points_of(data)[:, :3].astype(float), lidarseg_of(data)
    assert len(label) == len(points) == 308
    for a, middle, axes, half in boxes_of(data):
        inside = (np.abs((points - middle) @ axes) <= half + 1e-5).all(axis=1)
        category = get('category', get('instance', a['instance_token'])['category_token'])['index']
        assert np.array_equal(inside, label == category), a['category_name']
        assert inside.sum() > 50
        boxes += 1
print(boxes, 'boxes')
)");
  EXPECT_THAT(printed, HasSubstr("8 boxes"));
}

// label = 1000 * class + instance, and 0 for what cannot be counted: buildings are things here, static.manmade is not.
TEST_F(NuScenesLayout, PanopticLabelsAreClassAndInstance) {
  write(*layout_, true);
  for (const std::size_t s : {0u, 1u}) {
    for (const std::size_t f : {0u, 1u}) {
      writeChanged(
          *layout_, s, f,
          [](ExportSample& changed) {
            Scan& scan = changed.scans[0].scan;
            for (std::size_t i = 0; i < scan.size(); ++i) {
              if (scan[kInstance][i] == 0 && isFinite(scan.position[i])) scan[kInstance][i] = 3;
            }
          },
          true);
    }
  }
  readTables(R"(
for data in lidar_data:
    points, label, panoptic = points_of(data), lidarseg_of(data), panoptic_of(data)
    assert panoptic.dtype == np.uint16
    assert len(points) == len(label) == len(panoptic) == 360 - 4   # the misses are left out
    assert np.isfinite(points).all()
    assert np.array_equal(panoptic // 1000, label)
    assert set(panoptic) == {28000, 17001, 2001}, set(panoptic)
    assert (panoptic == 17001).sum() == 72
)");
}

// Ids of towns are large. Each has the same number in all frames, whichever of them are written, and in which order.
TEST_F(NuScenesLayout, InstancesAreNumberedOverTheFramesOfAScene) {
  const auto change = [&](ExportSample& changed) {
    if (changed.sequence != 0) return;
    Scan& scan = changed.scans[0].scan;
    std::fill(scan[kInstance].begin(), scan[kInstance].end(), 0);
    std::fill(scan[kLabel].begin(), scan[kLabel].end(), classId("car"));
    const std::vector<std::uint32_t> ids = changed.frame == 0
                                               ? std::vector<std::uint32_t>{90'000, 5, 70'000}
                                               : std::vector<std::uint32_t>{80'000, 70'000, 4'000'000'000};
    for (std::size_t i = 0; i < 3; ++i) scan[kInstance][i] = ids[i];
    scan[kLabel][2] = classId("truck");  // 70000 has points of two classes in all
  };
  writeChanged(*layout_, 0, 0, change);
  writeChanged(*layout_, 0, 1, change);
  // Cars: 5, 70000 (of frame 1), 80000, 90000; trucks: 70000 and the last.
  python(fmt::format(R"(
found = [np.load(folder / file)['data'][:4].tolist() for file in ('{}', '{}')]
assert found == [[17004, 17001, 23001, 17000], [17003, 17002, 23002, 17000]], found
)",
                     labelFile(plan_, plan_.manifest.samples[0], 0, NuScenesLabels::Panoptic).string(),
                     labelFile(plan_, plan_.manifest.samples[1], 0, NuScenesLabels::Panoptic).string()));
}

TEST_F(NuScenesLayout, RefusesMoreInstancesThanThePanopticLabelsHold) {
  ASSERT_TRUE(layout_->checksSamples(plan_));
  const auto withCars = [&](std::size_t frame, std::uint32_t firstId, std::size_t count) {
    ExportSample full = sample(0, frame);
    Scan& scan = full.scans[0].scan;
    for (std::size_t i = 0; i < count; ++i) {
      scan.position.push_back({1, 2, 3});
      for (auto* column : {&scan[kIntensity], &scan[kTime], &scan[kRangeTrue]}) column->push_back(0);
      for (auto* column : {&scan[kLabel], &scan[kRing], &scan[kColumn]}) column->push_back(0);
      scan[kLabel].back() = classId("car");
      scan[kInstance].push_back(firstId + static_cast<std::uint32_t>(i));
    }
    return full;
  };
  // With the car 7 these are 999 of one class, and as many of another sequence do not count.
  layout_->checkSample(plan_, withCars(0, 1000, 998));
  layout_->checkSample(plan_, withCars(1, 1000, 998));
  ExportSample other = withCars(0, 5000, 900);
  other.sequence = 1;
  layout_->checkSample(plan_, other);
  expectInputError([&] { layout_->checkSample(plan_, withCars(1, 1000, 999)); },
                   {"street-s1-lane-000001", "999", "vehicle.car"});
}

TEST_F(NuScenesLayout, RefusesWhatNuScenesCannotTellApart) {
  layout_->check(plan_);
  const ExportPlan whole = plan_;
  plan_.manifest.samples[3].scans[0].time = 4e-7;
  expectInputError([&] { layout_->check(plan_); }, {"street-s2-lane-000001", "microsecond"});
  plan_.manifest.samples[3].scans[0].time = 86400;
  expectInputError([&] { layout_->check(plan_); }, {"street-s2-lane-000001", "86400 s", "a day"});
  plan_.manifest.samples[3].scans.clear();
  expectInputError([&] { layout_->check(plan_); }, {"street-s2-lane-000001", "'top'"});
  plan_.manifest.samples = whole.manifest.samples;
  plan_.classes = ClassMap(plan_.manifest.ontology, plan_.manifest.ontology);  // whose ids have gaps
  expectInputError([&] { layout_->check(plan_); }, {"scanmill", "without gaps", "labels/nuscenes.yaml"});
}

TEST_F(NuScenesLayout, WritesLabelsThatThereAre) {
  plan_.manifest.sensors[0].beams.elevation = {0.2, 0.1, -0.3, 0.0};  // without a ring number all rings are 0
  std::erase(plan_.manifest.columns, "instance");
  writeChanged(*layout_, 0, 0, [](ExportSample& changed) { changed.scans[0].scan[kInstance].clear(); });
  EXPECT_EQ(bytesOf(labelFile(plan_, plan_.manifest.samples[0], 0, NuScenesLabels::Lidarseg)).size(), 308u);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "panoptic"));
  std::erase(plan_.manifest.columns, "label");
  for (std::size_t s = 0; s < 2; ++s) {
    for (std::size_t f = 0; f < 2; ++f) {
      writeChanged(*layout_, s, f, [](ExportSample& changed) {
        Scan bare;
        bare.position = changed.scans[0].scan.position;
        changed.scans[0].scan = bare;
      });
    }
  }
  std::filesystem::remove_all(folder_.path() / "lidarseg");
  layout_->finish(
      plan_, [&](std::size_t s, std::size_t f) { return objects(s, f); }, folder());
  readTables(R"(
assert 'lidarseg' not in names and 'panoptic' not in names
points = points_of(lidar_data[0])
assert len(points) == 308 and (points[:, 3:] == 0).all() and (points[:, :2] != 0).any()
)");
}

TEST_F(NuScenesLayout, TellsThatThereIsNoBox) {
  write(*layout_);
  for (SampleRecord& sample : plan_.manifest.samples) sample.objects.emplace();
  const auto without = [&](std::size_t s, std::size_t f) {
    SampleObjects all = objects(s, f);
    all.objects.clear();
    return std::optional(all);
  };
  EXPECT_THAT(layout_->finish(plan_, without, folder()), testing::Contains(testing::HasSubstr("there is no box")));
  const auto with = [&](std::size_t s, std::size_t f) { return objects(s, f); };
  EXPECT_THAT(layout_->finish(plan_, with, folder()),
              testing::Not(testing::Contains(testing::HasSubstr("there is no box"))));
}

// Of several returns the second plane of an organised scan has the same rings again.
TEST_F(NuScenesLayout, RowsOfOrganisedScansAreRings) {
  const auto change = [](ExportSample& changed) {
    Scan image;
    image.rings = 4;
    image.columns = 3;
    image.planes = 2;
    image.organised = true;
    image.position.assign(24, Vec3f{3, 4, 5});
    image.position[5].y = std::numeric_limits<float>::quiet_NaN();
    image[kLabel].assign(24, 0);
    image[kInstance].assign(24, 0);
    changed.scans[0].scan = image;
  };
  writeChanged(*layout_, 0, 0, change);
  const std::string bytes = firstPoints();
  ASSERT_EQ(bytes.size(), 23u * 20);
  for (std::size_t i = 0; i < 23; ++i) {
    float ring = 0;
    std::memcpy(&ring, bytes.data() + 20 * i + 16, 4);
    EXPECT_EQ(ring, "00011222333000111222333"[i] - '0');
  }
}

}  // namespace
}  // namespace scanmill
