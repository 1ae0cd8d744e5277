// Writes tradeoff.json. The function describe() of each struct names its keys.

#include <concepts>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "dataset/json_text.h"
#include "study/tradeoff/study.h"

namespace scanmill {

namespace {

void describe(auto& a, const Spread& s) {
  a("count", s.count)("mean", s.mean)("rms", s.rms)("median", s.median)("p95", s.p95)("p99", s.p99)("p999", s.p999)(
      "max", s.max);
}

void describe(auto& a, const GroupErrors& g) {
  a("beams", g.beams)("both_hit", g.bothHit)("both_miss", g.bothMiss)("false_negatives", g.falseNegatives)(
      "false_positives", g.falsePositives)("unresolved", g.unresolved)("same_class", g.sameClass)(
      "same_instance", g.sameInstance)("same_label", g.sameLabel)("range_m", g.range)("intensity", g.intensity)(
      "nearest_to_m", g.nearestTo)("nearest_from_m", g.nearestFrom);
}

void describe(auto& a, const ErrorGroup& g) {
  a("name", g.name)("low", g.low)("high", g.high)("errors", g.errors);
}

void describe(auto& a, const SizeRecall& r) {
  a("name", r.name)("low_m", r.low)("high_m", r.high)("things", r.instances)("things_found", r.instancesFound)(
      "beams", r.beams)("beams_found", r.beamsFound);
}

void describe(auto& a, const BeamErrors& e) {
  a("all", e.all)("by_range", e.byRange)("by_incidence", e.byIncidence)("by_place", e.byEdge)("by_class", e.byClass)(
      "by_thickness", e.byThickness)("by_length", e.byLength);
}

void describe(auto& a, const Cost& c) {
  a("setup_s", c.setupSeconds)("scan_s", c.scanSeconds)("fastest_s", c.fastest)("slowest_s", c.slowest)(
      "stages_s", c.stages)("memory_bytes", c.memoryBytes)("resident_bytes", c.residentBytes);
}

void describe(auto& a, const Measurement& m) {
  a("cost", m.cost)("errors", m.errors)("warnings", m.warnings);
}

void describe(auto& a, const Setting& s) {
  a("name", s.name)("method", s.method)("options", s.options);
}

void describe(auto& a, const SettingResult& r) {
  a("setting", r.setting)("failure", r.failure)("measured", r.measured);
}

void describe(auto& a, const EncodingResult& e) {
  a("name", e.name)("format", e.format)("options", e.options)("failure", e.failure)(
      "encode_points_per_s", e.encodePointsPerSecond)("decode_points_per_s", e.decodePointsPerSecond)(
      "bytes_per_point", e.bytesPerPoint)("largest_error_m", e.largestError)("stated_error_m", e.statedError);
}

void describe(auto& a, const SensingResult& r) {
  a("name", r.name)("failure", r.failure)("trace_s", r.traceSeconds)("effects_s", r.effectsSeconds)("beams", r.beams)(
      "both", r.both)("missing", r.missing)("added", r.added)("same_class", r.sameClass)("distance_m", r.distance)(
      "intensity", r.intensity);
}

void describe(auto& a, const StudyMachine& m) {
  a("processor", m.processor)("threads", m.threads)("renderer", m.renderer);
}

void describe(auto& a, const StudyScene& s) {
  a("key", s.key)("triangles", s.triangles)("frames", s.frames);
}

// The contents of the picture are not part of the JSON; they are stored in a file beside it.
void describe(auto& a, const ErrorPicture& p) {
  a("setting", p.setting)("title", p.setting);
}

void describe(auto& a, const Study& s) {
  a("program_version", s.programVersion)("date", s.date)("machine", s.machine)("pipeline_name", s.pipelineName)(
      "pipeline_file", s.pipelineFile)("budget_given", s.budgetGiven)("pipeline_text", s.pipelineText)(
      "budget_s", s.budgetSeconds)("repeats", s.repeats)("seconds", s.seconds)("scene", s.scene)("sensors", s.sensors)(
      "shots", s.shots)("beams_per_shot", s.beamsPerShot)("ontology", s.ontology)("settings", s.settings)(
      "common_stages_s", s.commonStages)("encodings", s.encodings)("sensing", s.sensing)("refused_methods", s.refused)(
      "left", s.leftOut)("pictures", s.pictures);
}

class JsonWriter {
 public:
  JsonWriter& operator()(const char* key, const auto& value) {
    object[key] = json(value);
    return *this;
  }
  OrderedJson object = OrderedJson::object();

 private:
  // Returns null for infinity, which JSON cannot store. Infinity occurs as the end of an open band.
  static OrderedJson json(double value) {
    return std::isinf(value) ? OrderedJson() : OrderedJson(finite(value, "study"));
  }
  static OrderedJson json(const std::string& value) { return value; }
  static OrderedJson json(const Ontology& value) { return ontologyJson(value); }
  static OrderedJson json(std::integral auto value) { return value; }
  template <class T>
  static OrderedJson json(const std::vector<T>& list) {
    OrderedJson array = OrderedJson::array();
    for (const T& item : list) array.push_back(json(item));
    return array;
  }
  static OrderedJson json(const std::map<std::string, double>& map) {
    OrderedJson object = OrderedJson::object();
    for (const auto& [key, value] : map) object[key] = json(value);
    return object;
  }
  template <class T>
  requires std::is_class_v<T>
  static OrderedJson json(const T& value) {
    JsonWriter writer;
    describe(writer, value);
    return std::move(writer.object);
  }
};

}  // namespace

std::string toJson(const Study& study) {
  JsonWriter writer;
  describe(writer, study);
  OrderedJson json{{"kind", "scanmill tradeoff"}, {"schema_version", Study::kSchemaVersion}};
  json.update(writer.object);
  return layOut(json) + "\n";
}

}  // namespace scanmill
