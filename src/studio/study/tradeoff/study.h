#pragma once

// The trade-off study: every method at several settings on a pipeline's own scene and sensors. What does each shortcut
// cost, where does it err, which setting should one take?

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evaluate/limits.h"
#include "evaluate/measure.h"
#include "pipeline/plan.h"
#include "pipeline/settings.h"
#include "scene/ontology.h"

namespace scanmill {

struct SettingResult {
  Setting setting;
  std::string failure;  // why it could not be measured; then all else is empty
  Measurement measured;
};

// How long scans of a sensor take with so many rings, its own elevations kept; the other columns unchanged.
struct RingTiming {
  std::uint32_t rings = 0;
  double scanSeconds = 0;  // median
};
// seconds = fixed + perRing * rings, by least squares of relative errors.
struct RingFit {
  Setting setting;
  std::vector<RingTiming> timings;
  double fixedSeconds = 0;
  double secondsPerRing = 0;
  double largestResidual = 0;  // relative
};

// Scans as bytes, one format at one bound.
struct EncodingResult {
  std::string name;     // "draco max_error_mm=10"
  std::string format;   // row of formats()
  std::string options;  // "{max_error_mm: 10}"
  std::string failure;
  double encodePointsPerSecond = 0;  // one thread
  double decodePointsPerSecond = 0;
  double bytesPerPoint = 0;
  double largestError = 0;  // m, of a position, measured by decoding
  double statedError = 0;   // m, that the format promises
};

// What the machine was.
struct StudyMachine {
  std::string processor;  // "AMD EPYC 9B14"
  int threads = 0;
  std::string renderer;  // OpenGL's, of the methods that draw or compute; empty: none was used
};

struct StudyScene {
  std::string key;  // of its sequence
  std::uint64_t triangles = 0;
  std::vector<std::uint32_t> frames;  // of which shots are
};

// The map of a scan whose beams err.
struct ErrorPicture {
  std::string setting;  // Setting::name
  std::string title;
  std::string png;  // bytes
};

struct Study {
  static constexpr int kSchemaVersion = 1;
  std::string programVersion;
  std::string date;  // "2026-11-20", UTC
  StudyMachine machine;
  std::string pipelineName;
  std::string pipelineFile;  // as it was named
  bool budgetGiven = false;  // by --budget
  std::string pipelineText;  // as Pipeline::text: with the overrides as comments
  std::uint64_t budgetSeconds = 0;
  int repeats = 0;
  double seconds = 0;  // that the study took
  StudyScene scene;
  std::vector<std::string> sensors;  // "top: paper_64, 64 x 2048 beams"
  std::uint64_t shots = 0;
  std::uint64_t beamsPerShot = 0;  // mean over the shots
  Ontology ontology;
  std::vector<SettingResult> settings;
  // What every setting's scans take alike, seconds a scan on one thread: "effects", "encode pcd" ... as the pipeline
  // has them.
  std::map<std::string, double> commonStages;
  std::vector<EncodingResult> encodings;
  std::vector<RingFit> rings;
  std::optional<RingFit> showing;      // drawing a picture of the first of these settings' scans; its setting is empty
  std::vector<std::string> left;       // what was left out for lack of time, one line each
  std::vector<ErrorPicture> pictures;  // their bytes are not in the JSON: files beside it

  // Of the settings that were measured.
  std::vector<Candidate> candidates() const;
};

// Plain words: which setting to take for which need, and what it gives up. One paragraph each; no HTML.
struct Advice {
  std::string need;     // "For exact ranges and labels", "What not to take": a heading
  std::string setting;  // Setting::name; empty: none holds
  std::string text;
};
std::vector<Advice> advise(const Study& study);

struct StudyOptions {
  double budgetSeconds = 0;  // 0: the pipeline's, or 300
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

// The pipeline's `tradeoff:` says what is compared; see study/tradeoff/settings.h. Throws InputError for unusable
// input. A setting that cannot run here (no Blender, say) is not an error of the study: its row says why.
Study runStudy(const Plan& plan, const StudyOptions& options);

// tradeoff.json: all but the pictures' bytes. The same figures come back, and from them the same report.
std::string toJson(const Study& study);
Study parseStudy(const std::string& text, const std::string& file);  // throws InputError
std::string toCsv(const Study& study);                               // a row per setting and group of beams

// index.html, self-contained, with charts and pictures.
std::string studyReport(const Study& study);
// pareto.svg: speed against error, the chart that the README shows.
std::string paretoSvg(const Study& study);

}  // namespace scanmill
