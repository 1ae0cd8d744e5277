// A program of somebody else: one turn of an installed sensor in an installed scene, and what is true of its points.

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "methods/method.h"
#include "scene/scene.h"
#include "scenefile/scene_file.h"
#include "sense/sense.h"
#include "sensors/sensor.h"
#include "sensors/shot.h"

using namespace scanmill;

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path share = argv[1];
  const Scene scene = readScene(share / "scenes/street.yaml", {.seed = 1, .ontology = {}});
  const double height = 1.9;  // m, above the road
  Shot shot;
  shot.beams = makeBeams(readYaml(share / "pipelines/sensors/vlp_16.yaml"));
  shot.worldFromSensor = {Pose{.rotation = {}, .translation = {0, -1.75, height}}};

  const ScanLayout layout{.columns = ColumnSet::byDefault().with(kRangeTrue)};
  const Value defaults;
  Fields options(defaults, "ray_tracing");
  Hits hits;
  requireMethod("ray_tracing", {}).make(scene, options)->trace(shot, channelsFor({}, layout.columns), hits);
  Returns returns;
  Scan scan;
  sense({.materials = scene.materials, .layout = layout}, hits, shot, returns, scan);

  // The street's road lies at z = 0; without noise a point is as far from its beam's origin as the beam's range says.
  const std::uint16_t road = scene.ontology.require("road", {}).id;
  std::size_t onRoad = 0;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const std::size_t beam = std::size_t{scan[kRing][i]} * shot.beams->columns + scan[kColumn][i];
    const Vec3f origin = shot.beams->origin.empty() ? Vec3f{} : shot.beams->origin[beam];
    if (std::abs(length(scan.position[i] - origin) - scan[kRangeTrue][i]) > 1e-3f) ++wrong;
    if (scan[kLabel][i] != road) continue;
    ++onRoad;
    if (std::abs(scan.position[i].z + height) > 1e-3) ++wrong;
  }
  std::printf("%zu points, %zu on the road, %zu wrong\n", scan.size(), onRoad, wrong);
  return scan.size() > 1000 && onRoad > 100 && wrong == 0 ? 0 : 1;
}
