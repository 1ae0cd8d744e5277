#pragma once

// The trade-off study measures every method at several settings on a pipeline's own scene and sensors. It shows what
// each shortcut costs, where the shortcut errs, and which setting to take.

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evaluate/limits.h"
#include "evaluate/measure.h"
#include "evaluate/settings.h"
#include "pipeline/plan/plan.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "study/tradeoff/sensing.h"

namespace scanmill {

struct SettingResult {
  Setting setting;
  std::string failure;  // why it could not be measured; then `measured` is empty
  Measurement measured;
};

// The time of a scan with this number of rings.
struct RingTiming {
  std::uint32_t rings = 0;
  double scanSeconds = 0;  // median
};
// The fit seconds = fixed + perRing * rings, by least squares of relative errors.
struct RingFit {
  Setting setting;
  std::vector<RingTiming> timings;
  double fixedSeconds = 0;
  double secondsPerRing = 0;
  double largestResidual = 0;  // relative
};

// Speed, size and error of scans in one format with one set of options.
struct EncodingResult {
  std::string name;     // "draco max_error_mm=10"
  std::string format;   // as in formats()
  std::string options;  // "{max_error_mm: 10}"
  std::string failure;
  double encodePointsPerSecond = 0;  // on one thread
  double decodePointsPerSecond = 0;  // on one thread
  double bytesPerPoint = 0;
  double largestError = 0;  // m, of a position; measured by decoding
  double statedError = 0;   // m; the bound that the format guarantees
};

// The machine on which the study ran.
struct StudyMachine {
  std::string processor;  // "AMD EPYC 9B14"
  int threads = 0;
  std::string renderer;  // the name of OpenGL's renderer; empty where no method used OpenGL
};

struct StudyScene {
  std::string key;                    // the key of the sequence, "street-s1-lane"
  std::uint64_t triangles = 0;        // with all instances
  std::vector<std::uint32_t> frames;  // the frames of the sequence that were scanned
};

// A picture of a scan that shows which beams of a setting err.
struct ErrorPicture {
  std::string setting;  // Setting::name
  std::string title;
  std::string png;  // the file's bytes
};

struct Study {
  static constexpr int kSchemaVersion = 3;
  std::string programVersion;
  std::string date;  // "2026-11-20", UTC
  StudyMachine machine;
  std::string pipelineName;
  std::string pipelineFile;  // as given on the command line
  bool budgetGiven = false;  // the budget was given by --budget, not by the pipeline
  std::string pipelineText;  // as Pipeline::text: with the overrides as comments
  std::uint64_t budgetSeconds = 0;
  int repeats = 0;
  double seconds = 0;  // wall time that the study took
  StudyScene scene;
  std::vector<std::string> sensors;  // "top: paper_64, 64 x 2048 beams"
  std::uint64_t shots = 0;
  std::uint64_t beamsPerShot = 0;  // mean over the shots
  Ontology ontology;
  std::vector<SettingResult> settings;
  // The stages whose times do not depend on the setting, by name, such as "effects" and "encode pcd": seconds per scan
  // on one thread.
  std::map<std::string, double> commonStages;
  std::vector<EncodingResult> encodings;
  // The cost of leaving out footprint, light paths or weather, the truth first; empty if the pipeline has none of them.
  std::vector<SensingResult> sensing;
  // Methods that the pipeline refuses, because they cannot do its footprint, light paths or moving objects.
  std::vector<std::string> refused;
  std::vector<RingFit> rings;
  // The time to show a scan of the first setting by number of rings, see StudyOptions::showScan. The fit's `setting` is
  // empty.
  std::optional<RingFit> showing;
  std::vector<std::string> left;       // lines on what was left out for lack of time
  std::vector<ErrorPicture> pictures;  // the PNG bytes are not in the JSON, but in files beside it

  // The settings that were measured, in their order.
  std::vector<Candidate> candidates() const;
};

// One paragraph of advice in plain words: which setting to take for a need, and the drawbacks of the setting.
struct Advice {
  std::string need;     // a heading: "For exact ranges and labels", "What not to take"
  std::string setting;  // Setting::name; empty where no setting is good enough
  std::string text;
};
std::vector<Advice> advise(const Study& study);

struct StudyOptions {
  double budgetSeconds = 0;  // 0 takes the pipeline's budget, or 300 s
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;  // true ends the study with an Error
  // Shows a scan; the time that it takes goes into Study::showing. If absent, showing is not timed.
  std::function<void(const Scan& scan, const Ontology& ontology)> showScan{};
  // Draws which beams of a setting err and returns the bytes of a PNG file. If absent, the study has no pictures.
  std::function<std::string(const TrueShot& truth, const Hits& tested)> drawErrors{};
};

// Runs the study that the pipeline's key `tradeoff` describes; see study/tradeoff/settings.h. Throws InputError for
// unusable input. A setting that cannot run here, such as one that needs Blender, is not an error: its row gives the
// reason.
Study runStudy(const Plan& plan, const StudyOptions& options);

// Returns the study as JSON, without the pictures' bytes: the file tradeoff.json.
std::string toJson(const Study& study);
// Reads back exactly what toJson() has written, to make the same report again. `file` is the name in messages. Throws
// InputError.
Study parseStudy(const std::string& text, const std::string& file);
// Returns the study as a table in CSV, a row per setting and group of beams: the file tradeoff.csv.
std::string toCsv(const Study& study);

}  // namespace scanmill
