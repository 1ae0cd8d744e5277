#include "pipeline/run/sample_maker.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "formats/reasons_png.h"
#include "methods/depth_camera/depth_camera.h"
#include "pipeline/read/drawn_sensors.h"
#include "pipeline/run/object_list.h"
#include "pipeline/run/run_records.h"
#include "pipeline/run/voxel_view.h"

namespace scanmill {

namespace {

// Returns the random values of a scene and of a frame's settings, sorted by key.
std::vector<DrawnValue> allDraws(const Scene& scene, const FrameSettings& settings) {
  std::vector<DrawnValue> draws = scene.draws;
  draws.insert(draws.end(), settings.draws.begin(), settings.draws.end());
  std::sort(draws.begin(), draws.end(), [](const DrawnValue& a, const DrawnValue& b) { return a.key < b.key; });
  return draws;
}

}  // namespace

SampleMaker::SampleMaker(ShotSource& source, std::filesystem::path keepHits, std::filesystem::path keepPasses,
                         bool overwrite, std::function<void(const Sequence&)> loading)
    : source_(source),
      plan_(source.plan()),
      keepHits_(std::move(keepHits)),
      keepPasses_(std::move(keepPasses)),
      overwrite_(overwrite),
      scenes_(source, std::move(loading)),
      recorder_(plan_) {}

MadeSample SampleMaker::make(const SampleAddress& address) {
  const Pipeline& pipeline = plan_.pipeline;
  const Sequence& sequence = pipeline.sequences[address.sequence];
  const std::shared_ptr<const ReadyScene> ready = scenes_.enter(address.sequence);
  // Open recordings only after the scene and the method are set up: --overwrite removes old recordings, which must not
  // happen if the new ones cannot be made.
  std::call_once(opened_, [&] { recorder_.open(keepHits_, keepPasses_, overwrite_); });
  recorder_.enter(address.sequence, ready->scene, *ready->method);
  MadeSample made{{sequence.key(address.frame), sequence.split, {}, {}, {}}, ready->facts};
  const Frame frame = source_.sample(address.sequence, address.frame);
  const FrameSettings& settings = *frame.settings;
  made.sample.draws = allDraws(ready->scene, settings);
  if (frame.shots.front().time != frame.time) made.sample.time = frame.time;
  TraceAccount account;
  std::optional<ObjectList> objects;
  std::unique_ptr<ShotBuffers> buffers = buffers_.take();
  for (const Shot& shot : frame.shots) {
    const ShotSetup setup = setupOf(plan_, settings, ready->scene, *ready->method, shot.sensor);
    if (recorder_.recordsPasses()) {
      account += drawAndRecord(*ready, shot, buffers->hits);
      const StageTimer timer(clock_, "effects");
      senseShot(setup, shot, buffers->hits, buffers->returns, buffers->scan);
    } else {
      account += runShot(setup, shot, *buffers, clock_);
    }
    // The list has one view of an object for each sensor: that of its first revolution in the sample.
    if (ready->objects != nullptr && shot.revolution == 0) {
      const StageTimer timer(clock_, "objects");
      if (!objects) objects.emplace(*ready->objects, made.sample.key, frame.time);
      objects->add(shot, pipeline.raysPerBeam(shot.sensor), buffers->hits, buffers->returns);
    }
    if (recorder_.recordsHits()) recorder_.writeHits(shot, buffers->hits);
    std::vector<ScanRecord>& scans = made.sample.scans;
    scans.push_back(recordOf(shot, buffers->hits, buffers->scan, pipeline.methodName()));
    if (pipeline.drawn != nullptr && pipeline.drawn->drawsMounts()) {
      scans.back().vehicleFromSensor = settings.sensors[shot.sensor].vehicleFromSensor;
    }
    addFormats(buffers->scan, made.sample);
    if (ready->voxels != nullptr) addVoxels(*ready->voxels, shot, *buffers, made.sample);
  }
  if (objects) {
    const SampleObjects listed = objects->finish();
    made.sample.objects = listed.counts();
    std::vector<Member>& members = made.sample.members;
    members.insert(members.begin(), {std::string(kObjectsSuffix), objectsJson(listed, ready->scene.ontology)});
  }
  buffers_.give(std::move(buffers));
  scenes_.account(address.sequence, account);
  scenes_.leave(address.sequence);
  return made;
}

// Encodes a scan in all formats, and the reasons of its beams if the pipeline asks for them, and adds the results to
// the sample's members. The scan's record must be the last in `sample.scans`.
void SampleMaker::addFormats(const Scan& scan, Sample& sample) {
  const StageTimer timer(clock_, "encode");
  const Pipeline& pipeline = plan_.pipeline;
  for (const ChosenFormat& f : pipeline.output.formats) {
    sample.members.push_back({memberSuffix(sample.scans.back(), f.format->suffix()), f.format->encode(scan)});
  }
  if (pipeline.output.layout.reasons) {
    sample.members.push_back({memberSuffix(sample.scans.back(), kReasonsSuffix),
                              encodeReasons(scan.reasonOfBeam, scan.rings, scan.columns)});
  }
}

void SampleMaker::addVoxels(const SceneVoxels& voxels, const Shot& shot, const ShotBuffers& buffers, Sample& sample) {
  const StageTimer timer(clock_, "voxels");
  const Pipeline& pipeline = plan_.pipeline;
  VoxelLabels labels = voxels.labels(*pipeline.output.voxels, shot.worldFromSensor.front(), shot.time);
  sample.members.push_back({memberSuffix(sample.scans.back(), kVoxelsSuffix),
                            encodeVoxels(viewVoxels(*pipeline.output.voxels, std::move(labels), shot,
                                                    pipeline.raysPerBeam(shot.sensor), buffers.hits, buffers.scan))});
}

// Renders the passes of a shot, records them, and fills `hits` by sampling the passes.
TraceAccount SampleMaker::drawAndRecord(const ReadyScene& ready, const Shot& shot, Hits& hits) {
  const DepthCamera& camera = *ready.method->depthCamera();
  hits.reset(shot.beams->rings, shot.beams->columns, plan_.channels);
  PassChoice choice = camera.passes(plan_.channels);
  choice.surfaceParameters = plan_.channels.has(Channel::Material);
  RecordedShot record = Recorder::beginPasses(shot);
  TraceAccount sampling;
  TraceAccount account = camera.draw(shot, choice, [&](PassStep&& step) {
    recorder_.writeStep(step, record);
    sampling += camera.sample(shot, step, hits);
  });
  recorder_.writePasses(record);
  return account += sampling;
}

void SampleMaker::finish() {
  recorder_.finish();
}

StageSeconds SampleMaker::stageSeconds() const {
  StageSeconds stages = clock_.seconds();
  const StageSeconds ofMethod = scenes_.methodSeconds();
  if (!ofMethod.empty()) stages.erase("trace");  // the method's own stages are listed instead of their sum
  for (const StageSeconds& own :
       {ofMethod, recorder_.stageSeconds(), StageSeconds{{"setup", scenes_.setupSeconds()}}}) {
    for (const auto& [stage, seconds] : own) stages[stage] = seconds;
  }
  return stages;
}

}  // namespace scanmill
