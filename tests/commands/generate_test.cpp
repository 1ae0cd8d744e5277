// Datasets as other programs find them, and runs that cannot end well.

#include <fmt/core.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

#include "base/file.h"
#include "dataset/dataset_folder.h"
#include "dataset/manifest.h"
#include "dataset/reader.h"
#include "tests/commands/program.h"
#include "tests/support/sanitizers.h"

namespace scanmill {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class Generate : public SmallWorld {
 protected:
  // Hours of work in shards of a megabyte.
  std::vector<std::string> longRun() const {
    return withSettings({testedProgram(), "generate", pipeline_, "-o", at("out")},
                        {"output={formats: [csv], shard_samples: 5}", "trajectories.0.every_s=1e-5",
                         "trajectories.0.frames=200000", "sensors.0.columns=512"});
  }

  // Waits until some shards have their names.
  void awaitShards(RunningProgram& process, std::size_t count) const {
    while (filesEndingIn(".tar", at("out")).size() < count) {
      ASSERT_TRUE(process.running()) << process.wait().error;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }

  void expectWholeShardsAndNoManifest() const {
    EXPECT_FALSE(std::filesystem::exists(at("out/manifest.json")));
    for (const auto& shard : filesEndingIn(".tar", at("out"))) {
      std::size_t members = 0;
      EXPECT_NO_THROW(readTar(shard, [&](const std::string& name, std::string_view bytes) {
        ++members;
        if (name.ends_with(".csv")) {
          EXPECT_GT(decodeMember(name, bytes).size(), 0u);
        }
      }));
      EXPECT_GT(members, 0u);
    }
    expectRefused(scanmill({"verify", at("out")}), "has an unfinished dataset");
  }
};

TEST_F(Generate, TellsWhatWasMadeAndVerifies) {
  const Outcome made = scanmill({"generate", pipeline_, "-o", at("out")});
  EXPECT_EQ(made.code, 0) << made.error;
  EXPECT_THAT(made.out, AllOf(HasSubstr("ground"), HasSubstr("4 samples in 1 shard,"), HasSubstr("2,048 beams gave"),
                              HasSubstr("beams/s"), HasSubstr("scanmill verify")));
  EXPECT_THAT(made.error, HasSubstr("generate 4/4 frames"));
  const Outcome sound = scanmill({"verify", at("out")});
  EXPECT_EQ(sound.code, 0);
  EXPECT_THAT(sound.out, HasSubstr("12 scan files"));
  EXPECT_THAT(sound.out, HasSubstr(": sound"));
  EXPECT_EQ(scanmill({"generate", pipeline_, "-q", "--overwrite", "-o", at("out")}).error, "");
}

TEST_F(Generate, ThreadsAndSeedsDoWhatTheySay) {
  const std::string noise = "effects=[range_noise: {sigma_m: 0.1}]";
  const auto shard = [&](const std::string& name, const std::vector<std::string>& more) {
    const Outcome o = scanmill(withSettings({"generate", pipeline_, "-q", "-o", at(name)}, {noise}, more));
    EXPECT_EQ(o.code, 0) << o.error;
    return readFile(at(name + "/train/train-000000.tar"));
  };
  const std::string one = shard("one", {"--threads", "1"});
  EXPECT_TRUE(one == shard("three", {"--threads=3"}));
  EXPECT_TRUE(one == shard("same", {"--seed", "1"}));
  EXPECT_FALSE(one == shard("other", {"--seed", "2"}));
}

TEST_F(Generate, MemoryStaysFlatHoweverManyScansAreMade) {
  if (kSanitized) GTEST_SKIP() << "sanitizers keep freed memory";
  const auto peak = [&](int frames) {
    const Outcome o = scanmill(
        withSettings({"generate", pipeline_, "-q", "--threads", "2", "-o", at(fmt::format("f{}", frames))},
                     {"sensors.0.columns=1024", "sensors.0.elevation_deg.rings=32", "trajectories.0.every_s=0.001",
                      fmt::format("trajectories.0.frames={}", frames), "output={formats: [pcd, draco], shard_mb: 8}"}));
    EXPECT_EQ(o.code, 0) << o.error;
    return static_cast<double>(o.peakBytes);
  };
  const double few = peak(30);
  EXPECT_LT(peak(300), 1.2 * few);
}

// Fewer frames at a time, the same bytes; or nothing at all.
TEST_F(Generate, AMemoryLimitIsKeptOrRefused) {
  if (kSanitized) GTEST_SKIP() << "sanitizers take memory of their own";
  const auto run = [&](const std::string& out, const std::vector<std::string>& more) {
    return scanmill(withSettings({"generate", pipeline_, "-q", "--threads", "8", "-o", at(out)},
                                 {"sensors.0.columns=2048", "sensors.0.elevation_deg.rings=128",
                                  "trajectories.0.frames=8", "output={formats: [pcd], shard_samples: 1}"},
                                 more));
  };
  ASSERT_EQ(run("free", {}).code, 0);
  const Outcome limited = run("limited", {"--memory-limit", "160M"});
  ASSERT_EQ(limited.code, 0) << limited.error;
  EXPECT_LT(limited.peakBytes, std::uint64_t{160} << 20);
  EXPECT_EQ(readFile(at("limited/manifest.json")), readFile(at("free/manifest.json")));
  expectRefused(run("refused", {"--memory-limit", "0.1G"}), "allow more, or take fewer sensors, rings, columns");
  EXPECT_FALSE(std::filesystem::exists(at("refused")));
}

// Scenes are set up one after the other where two do not fit, and give back what they took.
TEST_F(Generate, AMemoryLimitIsKeptWithSeveralScenes) {
  const std::string pipeline =
      folder_
          .write("seeds.yaml", std::string("name: seeds\nscenes: [{scene: ") + SCANMILL_SOURCE_DIR +
                                   "/scenes/street.yaml, seeds: [1, 2, 3, 4]}]\n"
                                   "trajectories: [{waypoints: [[-10, -1.75, 0], [10, -1.75, 0]], speed: 5, "
                                   "every_s: 0.2, frames: 6}]\nsensors: [{preset: " +
                                   SCANMILL_SOURCE_DIR +
                                   "/pipelines/sensors/hdl_64e.yaml, mount: {position: [0, 0, 1.9]}}]\n"
                                   "method: ray_tracing\noutput: {formats: [pcd], shard_samples: 3}\n")
          .string();
  const Outcome limited =
      scanmill({"generate", pipeline, "-q", "-o", at("seeds"), "--threads", "2", "--memory-limit", "290M"});
  ASSERT_EQ(limited.code, 0) << limited.error;
  EXPECT_LT(limited.peakBytes, std::uint64_t{290} << 20);
}

TEST_F(Generate, StoppedRunsSaySo) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    std::filesystem::remove_all(at("out"));
    RunningProgram process(longRun());
    awaitShards(process, 1);
    expectRefused(scanmill({"generate", pipeline_, "-q", "-o", at("out")}), "is being written by process");
    process.send(signal);
    const Outcome o = process.wait(10);
    EXPECT_FALSE(o.late);
    EXPECT_EQ(o.code, 128 + signal) << o.error;
    EXPECT_THAT(o.error, HasSubstr("error: stopped"));
    expectWholeShardsAndNoManifest();
    EXPECT_THAT(o.error, HasSubstr("--resume"));
    EXPECT_TRUE(filesEndingIn(".partial", at("out")).empty());
  }
}

// Whatever the number of processes, whoever is killed: one set of bytes.
TEST_F(Generate, SharedOutOverProcessesTheDatasetIsTheSame) {
  const auto command = [&](const std::string& folder, const std::vector<std::string>& more) {
    return withSettings({testedProgram(), "generate", pipeline_, "-q", "-o", at(folder)},
                        {"output={formats: [csv], shard_samples: 2}", "trajectories.0.every_s=1e-3",
                         "trajectories.0.frames=100", "sensors.0.columns=512"},
                        more);
  };
  const auto expectSame = [&](const std::string& folder) {
    SCOPED_TRACE(folder);
    const auto files = filesEndingIn("", at("whole"));
    for (const auto& file : files) {
      const auto same = std::filesystem::path(at(folder)) / file.lexically_relative(at("whole"));
      EXPECT_EQ(readFile(same), readFile(file)) << same;
    }
    EXPECT_EQ(filesEndingIn("", at(folder)).size(), files.size());
  };
  ASSERT_EQ(RunningProgram(command("whole", {})).wait().code, 0);
  {
    std::vector<std::unique_ptr<RunningProgram>> workers;
    for (const std::string worker : {"0", "1", "2"}) {
      workers.push_back(
          std::make_unique<RunningProgram>(command("three", {"--worker", worker, "--workers", "3", "--threads", "1"})));
    }
    for (const auto& worker : workers) EXPECT_EQ(worker->wait().code, 0);
    EXPECT_FALSE(std::filesystem::exists(at("three/manifest.json")));
    EXPECT_EQ(scanmill({"merge", at("three")}).code, 0);
    expectSame("three");
  }
  for (const std::size_t count : {2, 8}) {
    const std::string folder = "auto" + std::to_string(count);
    std::vector<std::unique_ptr<RunningProgram>> workers;
    for (std::size_t i = 0; i < count; ++i) {
      workers.push_back(std::make_unique<RunningProgram>(command(folder, {"--workers", "auto", "--threads", "1"})));
    }
    while (workers[0]->running() && filesEndingIn(".tar.json", at(folder)).size() < 5) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    workers[0]->send(SIGKILL);
    for (std::size_t i = 0; i < count; ++i) {
      const Outcome outcome = workers[i]->wait();
      EXPECT_TRUE(i == 0 || outcome.code == 0) << outcome.error;
    }
    expectSame(folder);
  }
}

TEST_F(Generate, EndsWithForecastBesideFact) {
  const Outcome large =
      scanmill({"generate", pipeline_, "-o", at("large"), "--set", "sensors.0.columns=20000", "--set",
                "sensors.0.elevation_deg.rings=128", "--set", "output.formats=[pcd: {encoding: binary}]"});
  EXPECT_EQ(large.code, 0) << large.error;
  EXPECT_THAT(large.out, ContainsRegex("\nforecast: [0-9.]+ s .*MiB.*; actual: [0-9.]+ s and [0-9.]+ MiB\n"));
  const Outcome small = scanmill({"generate", pipeline_, "-o", at("small")});
  EXPECT_THAT(small.out, Not(HasSubstr("forecast"))) << "which would take longer than the dataset";
}

TEST_F(Generate, AWorkerWithoutAShardIsTold) {
  const Outcome idle = scanmill({"generate", pipeline_, "-o", at("idle"), "-q", "--worker", "7", "--workers", "8"});
  EXPECT_EQ(idle.code, 0) << idle.error;
  EXPECT_THAT(idle.error, HasSubstr("worker 7 of 8 has no shard to make: the dataset has 1 shard;"));
}

}  // namespace
}  // namespace scanmill
