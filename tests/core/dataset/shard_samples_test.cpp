#include "dataset/shard_samples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "dataset/objects.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// A dataset of two samples, with all that records can have.
class ShardSamples : public testing::Test {
 protected:
  ShardSamples() {
    PackedDataset writer(folder_.path() / "data", false, 1 << 20);
    for (std::uint32_t i = 0; i < 2; ++i) {
      Sample sample = testSample(manifest_, i, "street-1-drive-00000" + std::to_string(i), "train");
      SampleObjects objects{sample.key, 0.1, {}};
      if (i == 0) {
        ObjectView view;
        view.sensor = "top";
        view.points = 5;
        ObjectRecord car;
        car.id = 3;
        car.semantic = 65535;
        car.size = {4, 2, 1};
        car.views = {view};
        objects.objects = {car};
      }
      sample.objects = objects.counts();
      sample.members.push_back({std::string(kObjectsSuffix), objectsJson(objects, manifest_.ontology)});
      sample.draws = {{"a.first", "0.1"}, {"b.second", "-0.0"}};
      sample.scans[0].unresolved = 1;
      sample.scans[1].vehicleFromSensor = Pose{fromYawPitchRoll(0.2, 0, 0), {-0.0, 1e-7, 3}};
      writer.add(sample);
    }
    writer.finish(manifest_);
  }

  TemporaryFolder folder_;
  Manifest manifest_ = testManifest();
};

TEST_F(ShardSamples, AreThoseOfTheManifest) {
  Manifest again = manifest_;
  again.samples = samplesOfShard(folder_.path() / "data", manifest_, 0);
  EXPECT_EQ(toJson(again), toJson(manifest_));
}

TEST_F(ShardSamples, ADamagedShardIsRefused) {
  const std::filesystem::path file = folder_.path() / "data" / manifest_.shards[0].file;
  const std::string sound = readFile(file);
  writeFile(file, sound.substr(0, sound.size() / 2));
  EXPECT_THROW(samplesOfShard(folder_.path() / "data", manifest_, 0), InputError);
  writeFile(file, sound);
  Members members = membersOf(file);
  members[0].second = "{\"key\": \"street-1-drive-000000\"}";
  writeMembers(file, members);
  EXPECT_THAT(messageOf<InputError>([&] { samplesOfShard(folder_.path() / "data", manifest_, 0); }),
              HasSubstr("street-1-drive-000000.json: does not describe a sample"));
}

}  // namespace
}  // namespace scanmill
