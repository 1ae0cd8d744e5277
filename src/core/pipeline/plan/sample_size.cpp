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
  double bytes = kHeaders + kDescription * sensors;
  if (pipeline.output.objects) bytes += kHeaders + kObjects * (kObject + kView * sensors);
  ScanOutline outline;
  outline.held = plan.columns();
  for (const auto& [beams, footprint] : plan.sensors) {
    outline.points = beams->size() * pipeline.mostReturns();
    outline.rings = beams->rings;
    outline.columns = beams->columns;
    outline.reach = 2 * beams->maxRange + kReserve;
    for (const ChosenFormat& f : pipeline.output.formats) bytes += kHeaders + std::ceil(f.format->mostBytes(outline));
    if (pipeline.output.layout.reasons) {
      bytes += kHeaders + static_cast<double>(mostReasonsBytes(beams->rings, beams->columns));
    }
    if (pipeline.output.voxels) bytes += kHeaders + static_cast<double>(mostVoxelsBytes(*pipeline.output.voxels));
  }
  return bytes;
}

}  // namespace scanmill
