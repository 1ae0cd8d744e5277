// A program of somebody else: makes a dataset from an installed pipeline through the library.

#include "pipeline/run/generate.h"

#include <cstdio>

#include "dataset/verify.h"
#include "pipeline/scenes/shot_source.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const scanmill::Plan plan = scanmill::makePlan(scanmill::readPipeline(
      argv[1], {"scenes.0.seeds=1", "splits=null", "trajectories.0.frames=1", "sensors.0.columns=256"}));
  const auto summary = scanmill::generate(plan, {.folder = argv[2], .quiet = true});
  const auto verification = scanmill::verifyDataset(argv[2]);
  std::printf("%llu points, %zu problems\n", static_cast<unsigned long long>(summary.points),
              verification.problems.size());
  return summary.points > 1000 && verification.problems.empty() ? 0 : 1;
}
