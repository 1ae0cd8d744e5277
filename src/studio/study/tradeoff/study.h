#pragma once

// The trade-off study measures every method with several settings on a pipeline's scene and sensors. It shows how much
// time each shortcut saves, which errors the shortcut causes, and which settings to prefer.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "evaluate/measure.h"
#include "evaluate/settings.h"
#include "pipeline/plan/plan.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "scene/scene.h"
#include "sensors/shot.h"

namespace scanmill {

// Times and errors of a variation that simplifies the sensor's physics (fewer rays per beam, no glass, no mirrors,
// clear air). The errors are differences between a beam's nearest return and its nearest return in the truth, which has
// the complete physics.
struct SensingResult {
  std::string name;           // what the variation simplifies, such as "7 rays a beam"
  std::string failure{};      // why the variation could not be measured; then the members below are empty
  double traceSeconds = 0;    // time to trace a scan with all threads (s)
  double effectsSeconds = 0;  // time to apply the effects to a scan with one thread (s)
  std::uint64_t beams = 0;
  std::uint64_t both = 0;       // number of beams with a return in both scans
  std::uint64_t missing = 0;    // number of beams with a return only in the truth
  std::uint64_t added = 0;      // number of beams with a return only in the variation
  std::uint64_t sameClass = 0;  // number of beams in `both` whose returns have the same class
  Spread distance{};            // distance between the two returns of each beam in `both` (m)
  double intensity = 0;         // mean absolute difference of the intensities of beams in `both`
};

// In the truth a beam has kTrueRays rays, each of which is reflected by at most kTrueBounces mirrors and passes at most
// kTruePanes glass panes.
constexpr std::uint32_t kTrueRays = 127;
constexpr std::uint32_t kTrueBounces = 2;
constexpr std::uint32_t kTruePanes = 8;

// Measures the variations by ray tracing. The first result is the truth, compared with itself: it has 127 rays per beam
// if the pipeline has the effect footprint, up to 2 mirrors and 8 panes per ray if the pipeline has light_paths, and
// the pipeline's weather. The other results simplify one or several of these; if the pipeline has footprint or
// light_paths, the last result has the pipeline's settings. All omit the ego vehicle and the noise of ranges and
// angles, and use the same random numbers. Returns nothing if the pipeline has none of these effects. `say`: called
// with a text about the progress. `stop`: called between scans; if it returns true, throws Error.
std::vector<SensingResult> measureSensing(const Plan& plan, const Scene& scene, std::span<const Shot> shots,
                                          const std::function<void(const std::string&)>& say,
                                          const std::function<bool()>& stop);

struct SettingResult {
  Setting setting;
  std::string failure;  // why the setting could not be measured; then `measured` is empty
  Measurement measured;
};

// Speed, size and error of encoding scans in one format with given options.
struct EncodingResult {
  std::string name;     // format and options, such as "draco max_error_mm=10"
  std::string format;   // the format's name in the table formats()
  std::string options;  // options as YAML text, such as "{max_error_mm: 10}"
  std::string failure{};
  double encodePointsPerSecond = 0;  // rate of encoding with one thread
  double decodePointsPerSecond = 0;  // rate of decoding with one thread
  double bytesPerPoint = 0;
  double largestError = 0;  // largest position error of decoded points (m)
  double statedError = 0;   // bound of the position error that the format guarantees (m)
};

// The machine on which the study ran.
struct StudyMachine {
  std::string processor;  // name of the processor, such as "AMD EPYC 9B14"
  int threads = 0;
  std::string renderer;  // name of the OpenGL device; empty if there is none or no method uses it
};

struct StudyScene {
  std::string key;                    // key of the sequence, such as "street-s1-lane"
  std::uint64_t triangles = 0;        // number of triangles of all instances
  std::vector<std::uint32_t> frames;  // numbers of the scanned frames in the sequence
};

// A picture of a scan that shows which beams are wrong with a setting.
struct ErrorPicture {
  std::string setting;  // name of the setting, see Setting::name
  std::string png;      // contents of the PNG file
};

struct Study {
  static constexpr int kSchemaVersion = 5;
  std::string programVersion;
  std::string date;  // UTC date of the study, such as "2026-11-20"
  StudyMachine machine;
  std::string pipelineName;
  std::string pipelineFile;  // path as given on the command line
  bool budgetGiven = false;  // true: the budget is from --budget
  std::string pipelineText;  // the pipeline's text with overrides as comments, see Pipeline::text
  std::uint64_t budgetSeconds = 0;
  int repeats = 0;
  double seconds = 0;  // duration of the study (s)
  StudyScene scene;
  std::vector<std::string> sensors;  // sensors with their sizes, such as "top: paper_64, 64 x 2048 beams"
  std::uint64_t shots = 0;
  std::uint64_t beamsPerShot = 0;  // number of beams, averaged over the shots
  Ontology ontology;
  std::vector<SettingResult> settings;
  // Time per scan (s, with one thread) of each stage that does not depend on the setting, such as "effects" and "encode
  // pcd".
  std::map<std::string, double> commonStages;
  std::vector<EncodingResult> encodings;
  // The cost of simplifying footprint, light paths or weather, see measureSensing(); empty if the pipeline has none of
  // them.
  std::vector<SensingResult> sensing;
  // Methods that the pipeline cannot use, since they do not support its light paths or moving objects.
  std::vector<std::string> refused;
  // Lines about parts that the study left out, such as settings that it had no time for.
  std::vector<std::string> leftOut;
  // Pictures of errors. Their contents are not stored in the JSON, but in files beside it.
  std::vector<ErrorPicture> pictures;
};

// The fastest setting that is good enough for one or several needs.
struct Advice {
  std::string need;     // such as "For exact ranges and labels", or "For centimetres; for speed at any price"
  std::string setting;  // name of the setting, see Setting::name; empty if none is good enough
  std::string text;     // speed and errors of the setting; if none is good enough, of the one nearest to the limits
};
// Returns the advice for all needs, in order; needs with equal settings share an entry. Empty if nothing was measured.
std::vector<Advice> advise(const Study& study);

// The options of a study are the key `tradeoff:` of a pipeline. All keys in it are optional.
//
//   tradeoff:
//     settings:                     # see evaluate/settings.h
//       - ray_tracing
//       - {depth_camera: {resolution: [512, 1024, 2048], sampling: [plane, nearest]}}
//     encodings: [pcd, {draco: {max_error_mm: [1, 10]}}]
//     sequence: street-s1-lane      # key of the sequence to scan (default: the first)
//     shots: 8                      # maximum number of frames to scan
//     repeats: 3                    # least number of timed scans per frame
struct StudyEncoding {
  std::string name;
  std::string options;
  ChosenFormat choice;
};

struct StudyChoice {
  std::vector<MethodSetting> settings;
  std::vector<StudyEncoding> encodings;
  std::size_t sequence = 0;  // index in Pipeline::sequences
  std::uint32_t shots = 8;
  int repeats = 3;
};

// Reads the key `tradeoff` of a pipeline. Throws InputError, with file and line, also for wrong options of settings.
StudyChoice readStudyChoice(const Pipeline& pipeline);

// Returns the settings that are measured if the pipeline lists none: all methods with their defaults, and variations
// with one or several options changed.
std::vector<MethodSetting> defaultSettings();

// Encodes and decodes each scan `repeats` times on one thread; the shortest time of a scan counts. Rates and sizes are
// per return; misses in organised scans need bytes, but do not count as points. The error is the distance between
// decoded and original positions. If encoding fails, sets EncodingResult::failure.
EncodingResult measureEncoding(const StudyEncoding& encoding, std::span<const Scan> scans, int repeats);

inline constexpr double kStudySeconds = 300;  // budget of a study for which none is given (s)

struct StudyOptions {
  double budgetSeconds = 0;  // approximate duration of the study (s); 0: kStudySeconds
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;  // if it becomes true, runStudy() throws Error; may be null
  // Draws which beams of a setting are wrong, and returns the contents of a PNG file. If null, no pictures are drawn.
  std::function<std::string(const TrueShot& truth, const Hits& tested)> drawErrors{};
};

// Runs the study that the pipeline's key `tradeoff` describes. Throws InputError for unusable input. If a setting
// cannot run on this machine, for instance because it needs Blender, this is not an error: the reason is stored in
// SettingResult::failure.
Study runStudy(const Plan& plan, const StudyOptions& options);

// Returns the study as JSON (the file tradeoff.json), without the contents of the pictures.
std::string toJson(const Study& study);

// Range errors below this (m) count as zero; the single-precision positions of scans are hardly finer at 100 m.
inline constexpr double kExactRange = 1e-5;

// Name of the group in BeamErrors::byEdge that contains the beams away from edges.
inline constexpr std::string_view kAwayFromEdges = "interior";

// Returns the errors of the group with this name; null if there is no such group.
const GroupErrors* errorsNamed(const std::vector<ErrorGroup>& groups, std::string_view name);

// Returns the fraction of all beams that are false negatives, false positives, unresolved or wrongly labelled.
double wrongShare(const GroupErrors& errors);
// Returns the 99th percentile of the range error (m); 0 if it is below kExactRange; NaN if no beam hits both in the
// truth and in the test.
double rangeP99(const GroupErrors& errors);

// Returns the number of beams that the setting traces per second; the time for the set-up does not count.
double beamsPerSecond(const Study& study, const SettingResult& result);
// True if the setting gives no options, so that all have their defaults.
bool isDefault(const Setting& setting);

// Returns the measured settings of a method, or of all methods if `method` is empty, as indices in Study::settings.
std::vector<std::size_t> measuredSettings(const Study& study, const std::string& method = "");

// Returns the Pareto front of time and an error, such as rangeP99(), as indices in Study::settings, the fastest first.
// If two settings on the front differ in time by less than repeated measurements do, only the more exact one is
// returned.
std::vector<std::size_t> frontOf(const Study& study, double (*error)(const GroupErrors&));

// Returns the index in Study::settings of ray tracing with default options; nothing if it was not measured.
std::optional<std::size_t> tracingDefault(const Study& study);
// Returns the names of the methods, in the order in which their settings occur.
std::vector<std::string> methodsOf(const Study& study);

}  // namespace scanmill
