#include "pipeline/plan/sample_size.h"

#include <cmath>

#include "dataset/voxels.h"
#include "formats/reasons_png.h"

namespace scanmill {

double mostSampleBytes(const Plan& plan) {
  constexpr double kHeaders = 1536;       // size of a tar member with a long name, without its contents (bytes)
  constexpr double kDescription = 16384;  // size of a scan's part of the sample's .json (bytes)
  constexpr double kObjects = 1000;       // assumed maximum number of objects near the sensors
  constexpr double kObject = 700;         // size of an object's entry without the sensors' views of it (bytes)
  constexpr double kView = 450;           // size of one sensor's view in an object's entry (bytes)
  // Length (m) that is added to twice the range, for noise and for the vehicle's motion during a revolution.
  constexpr double kReserve = 10;
  const Pipeline& pipeline = plan.pipeline;
  const auto sensors = static_cast<double>(plan.sensors.size());
  double bytes = kHeaders;
  if (pipeline.output.objects) bytes += kHeaders + kObjects * (kObject + kView * sensors);
  ScanOutline outline;
  outline.held = plan.columns();
  for (std::size_t s = 0; s < plan.sensors.size(); ++s) {
    const std::shared_ptr<const BeamTable>& beams = plan.sensors[s].beams;
    double scan = kDescription;
    outline.points = beams->size() * pipeline.mostReturns();
    outline.rings = beams->rings;
    outline.columns = beams->columns;
    outline.reach = 2 * beams->maxRange + kReserve;
    for (const ChosenFormat& f : pipeline.output.formats) scan += kHeaders + std::ceil(f.format->mostBytes(outline));
    if (pipeline.output.layout.reasons) {
      scan += kHeaders + static_cast<double>(mostReasonsBytes(beams->rings, beams->columns));
    }
    if (pipeline.output.voxels) scan += kHeaders + static_cast<double>(mostVoxelsBytes(*pipeline.output.voxels));
    bytes += scan * pipeline.sensors[s].revolutions;
  }
  return bytes;
}

}  // namespace scanmill
