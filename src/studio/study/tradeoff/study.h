#pragma once

// The trade-off study measures every method at several settings on a pipeline's own scene and sensors. It answers what
// each shortcut costs, where it errs, and which setting to take.

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
  std::string failure;  // why it could not be measured; then the measurement is empty
  Measurement measured;
};

// How long a scan takes with so many rings.
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

// What one format with one set of options makes of scans.
struct EncodingResult {
  std::string name;     // "draco max_error_mm=10"
  std::string format;   // the name of its row of formats()
  std::string options;  // "{max_error_mm: 10}"
  std::string failure;
  double encodePointsPerSecond = 0;  // on one thread
  double decodePointsPerSecond = 0;  // on one thread
  double bytesPerPoint = 0;
  double largestError = 0;  // m, of a position; measured by decoding
  double statedError = 0;   // m; the bound that the format promises
};

// The machine on which the study ran.
struct StudyMachine {
  std::string processor;  // "AMD EPYC 9B14"
  int threads = 0;
  std::string renderer;  // the name of OpenGL's renderer; empty where no method used OpenGL
};

struct StudyScene {
  std::string key;                    // the sequence's, "street-s1-lane"
  std::uint64_t triangles = 0;        // placed ones
  std::vector<std::uint32_t> frames;  // the frames of the sequence that were scanned
};

// A picture of a scan that shows where the beams of a setting err.
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
  std::string pipelineFile;  // as it was named
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
  // The stages that take the same whatever the setting, by name, such as "effects" and "encode pcd": seconds a scan on
  // one thread.
  std::map<std::string, double> commonStages;
  std::vector<EncodingResult> encodings;
  // What leaving out footprint, light paths or weather costs, the truth first; empty where the pipeline has none of
  // them.
  std::vector<SensingResult> sensing;
  // Methods that the pipeline refuses as it is: its footprint, light paths or moving objects ask for more than they
  // can.
  std::vector<std::string> refused;
  std::vector<RingFit> rings;
  // How long it takes to show a scan of the first setting with so many rings, see StudyOptions::showScan. Its own
  // setting is empty.
  std::optional<RingFit> showing;
  std::vector<std::string> left;       // what was left out for lack of time, one line each
  std::vector<ErrorPicture> pictures;  // their bytes are not in the JSON, but in files beside it

  // The settings that were measured, in their order.
  std::vector<Candidate> candidates() const;
};

// One paragraph of advice in plain words: which setting to take for a need, and what it gives up.
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
  // Shows a scan in some way; its time stands in Study::showing. Absent: it is not timed.
  std::function<void(const Scan& scan, const Ontology& ontology)> showScan{};
  // Draws where the beams of a setting err, as the bytes of a PNG file. Absent: the study has no pictures.
  std::function<std::string(const TrueShot& truth, const Hits& tested)> drawErrors{};
};

// Runs the study that the pipeline's key `tradeoff` describes; see study/tradeoff/settings.h. Throws InputError for
// unusable input. A setting that cannot run here, such as one that needs Blender, is no error of the study: its row
// says why it could not be measured.
Study runStudy(const Plan& plan, const StudyOptions& options);

// The study as JSON, all but the pictures' bytes: the file tradeoff.json.
std::string toJson(const Study& study);
// Reads back what toJson() has written, figure by figure, so that the same report can be made again. `file` is the name
// for messages. Throws InputError.
Study parseStudy(const std::string& text, const std::string& file);
// The study as a table in CSV, a row per setting and group of beams: the file tradeoff.csv.
std::string toCsv(const Study& study);

}  // namespace scanmill
