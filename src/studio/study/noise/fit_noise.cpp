#include "study/noise/fit_noise.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "base/error.h"
#include "base/random.h"
#include "base/short_text.h"
#include "base/text_scan.h"
#include "config/fields.h"
#include "config/resources.h"
#include "config/value.h"
#include "study/linear_fit.h"

namespace scanmill {

namespace {

constexpr std::size_t kFewestPatches = 50;  // least number of patches in a band that the fit uses
constexpr double kMostUneven = 2.5;         // largest `unevenness` (see fit_noise.h) of a band that the fit uses
constexpr int kResamples = 200;             // number of sets of patches for a bootstrap error
constexpr double kGoodChiSquare = 3;        // largest acceptable chi^2 per degree of freedom
constexpr double kGoodMisfit = 0.1;         // if no band has a larger relative error, any chi^2 is acceptable
constexpr double kLeastError = 1e-6;        // a band's standard error counts as at least this (m)

using FlatPatches = std::vector<const FlatPatch*>;

// Returns the standard deviation (m) that is typical of the patches; 0 if there are no patches. It is computed from the
// median of the patches' variances, so that a few curved or rough patches do not affect it.
double commonDeviation(const FlatPatches& patches) {
  std::vector<double> variances;
  for (const FlatPatch* p : patches) {
    const SurfaceFit& lines = p->measuredLines;
    if (lines.freedom > 0) variances.push_back(lines.variance() / chiSquareQuantile(lines.freedom, 0));
  }
  return std::sqrt(medianOf(std::move(variances)));
}

// Returns the deviation without the effect of rounding ranges to a step, which adds step^2 / 12 to the variance. The
// formula holds if the ranges on a patch vary by more than a step.
double withoutStep(double deviation, double step) {
  return std::sqrt(std::max(0.0, deviation * deviation - step * step / 12));
}

// Returns the bootstrap standard error of `measure`: its standard deviation over samples of the patches with
// replacement (Efron, "Bootstrap methods: another look at the jackknife", 1979); 0 for fewer than two patches. Complete
// patches are sampled, since points of one patch are not independent. `stream`: selects the random numbers.
double bootstrapError(const FlatPatches& patches, std::uint32_t stream,
                      const std::function<double(const FlatPatches&)>& measure) {
  if (patches.size() < 2) return 0;
  std::vector<double> values;
  values.reserve(kResamples);
  FlatPatches sampled(patches.size());
  for (std::uint32_t round = 0; round < kResamples; ++round) {
    for (std::uint32_t i = 0; i < patches.size(); ++i) {
      const RandomBlock block =
          randomBlock({.scene = stream, .frame = round, .beam = i, .purpose = Purpose::Bootstrap});
      sampled[i] = patches[static_cast<std::size_t>(uniform(block[0]) * static_cast<double>(patches.size()))];
    }
    values.push_back(measure(sampled));
  }
  return deviationOf(values);
}

// Returns FlatPatch::holes divided by FlatPatch::enclosed, over all patches. `stream`: selects the random numbers.
MeasuredShare dropOutOf(const FlatPatches& patches, std::uint32_t stream) {
  const auto count = [](const FlatPatches& counted) {
    MeasuredShare dropOut;
    for (const FlatPatch* p : counted) {
      dropOut.lost += p->holes;
      dropOut.beams += p->enclosed;
    }
    return dropOut;
  };
  MeasuredShare dropOut = count(patches);
  if (dropOut.beams == 0) return dropOut;
  // If no return is lost, the bootstrap error is 0, which is too small; the error is then the share of one lost return.
  dropOut.error =
      dropOut.lost == 0
          ? 1 / static_cast<double>(dropOut.beams)
          : bootstrapError(patches, stream, [&](const FlatPatches& sampled) { return count(sampled).share(); });
  return dropOut;
}

// Returns the noise on the patches of one band of ranges. `high`: the band's upper end (m). `step`: see NoiseFit::step.
// `stream`: selects the random numbers.
PatchGroup measureBand(const FlatPatches& patches, std::string name, double high, double step, std::uint32_t stream) {
  constexpr double kOneSigma = 0.84;  // probability below one standard deviation of the normal distribution
  PatchGroup group{.name = std::move(name), .high = high, .dropOut = dropOutOf(patches, 2 * stream)};
  FlatPatches measured;  // patches whose measured half has enough returns
  std::vector<double> ranges, planeVariances, variances;
  for (const FlatPatch* p : patches) {
    if (p->measuredLines.freedom <= 0) continue;
    measured.push_back(p);
    group.points += p->points;
    ranges.push_back(p->range);
    planeVariances.push_back(p->measuredPlane.variance() / chiSquareQuantile(p->measuredPlane.freedom, 0));
    variances.push_back(p->measuredLines.variance());
  }
  group.patches = measured.size();
  if (measured.empty()) return group;
  group.range = meanOf(ranges);
  group.withStep = commonDeviation(measured);
  group.sigma = withoutStep(group.withStep, step);
  group.planeSigma = withoutStep(std::sqrt(medianOf(planeVariances)), step);
  group.error = bootstrapError(measured, 2 * stream + 1,
                               [&](const FlatPatches& sampled) { return withoutStep(commonDeviation(sampled), step); });
  const double freedom = measured.front()->measuredLines.freedom;
  const double median = medianOf(variances);
  if (median > 0) {
    group.unevenness =
        quantileOf(variances, kOneSigma) / median / (chiSquareQuantile(freedom, 1) / chiSquareQuantile(freedom, 0));
  }
  return group;
}

// Returns the reason why the fit does not use a band of ranges; empty if the fit uses the band.
std::string whyLeftOut(const PatchGroup& band) {
  if (band.patches < kFewestPatches) return fmt::format("has fewer than {} patches", kFewestPatches);
  if (band.unevenness > kMostUneven) return "not flat: the patches scatter too differently";
  return {};
}

// Returns the noise in each range band that has patches. `step`: see NoiseFit::step.
std::vector<PatchGroup> measureBands(const FlatPatches& patches, double step) {
  const std::vector<double> edges = rangeBandEdges();
  std::vector<FlatPatches> perBand(edges.size());
  for (const FlatPatch* p : patches) perBand[rangeBandOf(p->range)].push_back(p);
  std::vector<PatchGroup> bands;
  for (std::size_t b = 0; b < edges.size(); ++b) {
    if (perBand[b].empty()) continue;
    const bool last = b + 1 == edges.size();
    const double high = last ? INFINITY : edges[b + 1];
    const std::string name = last ? fmt::format("from {:g} m", edges[b]) : fmt::format("{:g}-{:g} m", edges[b], high);
    bands.push_back(measureBand(perBand[b], name, high, step, static_cast<std::uint32_t>(b)));
    bands.back().leftOut = whyLeftOut(bands.back());
  }
  return bands;
}

// Returns the weight of a band's equation in the fit (1/m): 1 / the standard error of sigma, at most 1 / kLeastError.
double weightOf(const PatchGroup& band) {
  return 1 / std::max(band.error, kLeastError);
}

// States which coefficients of the line are fitted; the others stay 0.
struct FreeTerms {
  bool base = true, growth = true;
};

// Fits the free coefficients (base and growth, in this order) to the sigmas of the bands; the others are 0.
LinearFit fitTerms(const std::vector<const PatchGroup*>& used, FreeTerms free) {
  std::vector<double> design, values;
  for (const PatchGroup* band : used) {
    const double weight = weightOf(*band);
    design.insert(design.end(), {free.base ? weight : 0, free.growth ? weight * band->range : 0});
    values.push_back(weight * band->sigma);
  }
  return fitLinear(design, 2, values);
}

// Sets the standard errors of both coefficients, from the inverse of the normal matrix.
void addStandardErrors(const std::vector<const PatchGroup*>& used, FreeTerms free, NoiseFit& fit) {
  double s = 0, sr = 0, srr = 0;  // sums of w, w * range and w * range^2; w: the squared weight
  for (const PatchGroup* band : used) {
    const double weight = std::pow(weightOf(*band), 2);
    s += weight;
    sr += weight * band->range;
    srr += weight * band->range * band->range;
  }
  const double determinant = s * srr - sr * sr;
  if (free.base && free.growth && determinant > 0) {
    fit.baseError = std::sqrt(srr / determinant);
    fit.growthError = std::sqrt(s / determinant);
  } else if (free.base) {
    fit.baseError = 1 / std::sqrt(s);
  } else {
    fit.growthError = 1 / std::sqrt(srr);
  }
}

// Fits the line sigma = base + growth * range to the bands. If a coefficient is negative, sets it to zero and fits the
// other alone, since noise cannot be negative and does not decrease with range.
void fitLine(NoiseFit& fit, const std::vector<const PatchGroup*>& used) {
  FreeTerms free{.base = true, .growth = used.size() > 1};
  LinearFit line = fitTerms(used, free);
  const bool fallsWithRange = line.coefficients[1] < 0;
  if (fallsWithRange || line.coefficients[0] < 0) {
    free = {.base = fallsWithRange, .growth = !fallsWithRange};
    line = fitTerms(used, free);
  }
  fit.base = line.coefficients[0];
  fit.growth = line.coefficients[1];
  fit.chiSquare = line.squares;
  fit.freedom = line.freedom();
  for (const PatchGroup* band : used) {
    const double modelled = fit.base + fit.growth * band->range;
    if (band->sigma > 0) fit.largestMisfit = std::max(fit.largestMisfit, std::abs(modelled / band->sigma - 1));
  }
  fit.linear = fit.freedom <= 0 || fit.chiSquare <= kGoodChiSquare * fit.freedom || fit.largestMisfit <= kGoodMisfit;
  addStandardErrors(used, free, fit);
}

constexpr std::size_t kMostFiles = 3;  // files that a text names

// Returns the item `ring_bias` of the effects as YAML, with the spreads of the rings' errors that are attributed to the
// sensor (kOwnErrors); empty if there are none.
std::string ringBiasYaml(const RingErrors& rings) {
  std::string keys;
  const auto add = [&](const RingSpread& spread, const char* key) {
    if (spread.agreement < kOwnErrors || spread.sigma <= 0) return;
    keys += fmt::format("{}{}: {:.2g}", keys.empty() ? "" : ", ", key, spread.sigma);
  };
  add(rings.range, "range_sigma_m");
  constexpr double kLeastDegrees = 0.002;  // elevations of sensors are stated to 0.001 deg at best
  if (rings.elevation.agreement >= kOwnErrors && degrees(rings.elevation.sigma) > kLeastDegrees) {
    keys += fmt::format("{}elevation_sigma_deg: {:.2g}", keys.empty() ? "" : ", ", degrees(rings.elevation.sigma));
  }
  add(rings.gain, "gain_sigma");
  if (keys.empty()) return {};
  std::string text =
      fmt::format("  # Rings differ: odd and even patches agree on their offsets by a correlation of {:.2f}",
                  rings.range.agreement);
  if (rings.gain.rings > 0) text += fmt::format(", on their\n  # gains by {:.2f}", rings.gain.agreement);
  text += fmt::format(" ({} rings).\n", rings.range.rings);
  if (rings.elevation.rings == 0) {
    text += "  # Without both walls and level ground, errors of elevation count as errors of range.\n";
  }
  return text + fmt::format("  - ring_bias: {{{}}}\n", keys);
}

// The lines of a file from index `first` to `end`, which is excluded.
struct LineSpan {
  std::size_t first, end;
};

std::string linesOf(const std::vector<std::string>& lines, LineSpan span) {
  std::string text;
  for (std::size_t i = span.first; i < span.end; ++i) text += lines[i] + "\n";
  return text;
}

// Returns the lines of the file's effects that `newEffects` does not replace (see withEffects()), and the comments
// above them. Throws InputError if two effects are on one line. `list`: the file's effects. `key`: lines of `effects`.
std::string keptEffects(const Value& list, const std::vector<std::string>& lines, LineSpan key,
                        const std::string& newEffects) {
  std::vector<std::string> replaced;
  const Value fitted = parseYaml(newEffects, list.where.file);
  for (const Value& item : fitted.find("effects")->items) replaced.push_back(readNamed(item, "an effect").name);
  const auto isReplaced = [&](std::string_view name) { return std::ranges::find(replaced, name) != replaced.end(); };
  if (isReplaced("range_noise")) replaced.insert(replaced.end(), {"dropout", "shell", "quantize"});
  // A fitted effect `intensity` replaces speckle too, since its noise includes speckle.
  if (isReplaced("intensity")) replaced.emplace_back("speckle");
  std::string kept;
  LineSpan item{key.first + 1, 0};  // an item with the comments above it
  for (std::size_t i = 0; i < list.items.size(); ++i, item.first = item.end) {
    const auto nameLine = static_cast<std::size_t>(list.items[i].where.line - 1);
    item.end = key.end;
    if (i + 1 < list.items.size()) {
      // The item ends before the comments that belong to the next item.
      item.end = static_cast<std::size_t>(list.items[i + 1].where.line - 1);
      while (item.end > nameLine + 1 && trimmed(lines[item.end - 1]).starts_with('#')) --item.end;
    }
    if (item.end <= nameLine) {
      throw InputError(list.items[i].where, "two effects on one line: give each a line of its own");
    }
    if (!isReplaced(readNamed(list.items[i], "an effect").name)) kept += linesOf(lines, item);
  }
  return kept;
}

}  // namespace

std::vector<const PatchGroup*> NoiseFit::usedBands() const {
  std::vector<const PatchGroup*> list;
  for (const PatchGroup& band : bands) {
    if (band.leftOut.empty()) list.push_back(&band);
  }
  return list;
}

NoiseFit fitNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                  const std::vector<FlatPatch>& patches) {
  NoiseFit fit;
  for (const RecordedScan& scan : scans) {
    fit.files.push_back(scan.name);
    fit.returns += scan.returns;
    fit.beams += beams.size();
  }
  fit.step = rangeStep(scans);
  fit.sensorReach = beams.maxRange;

  FlatPatches steep;  // patches with steep incidence
  for (const FlatPatch& p : patches) {
    if (p.incidence >= kSteep) steep.push_back(&p);
  }
  fit.bands = measureBands(steep, fit.step);
  const std::vector<const PatchGroup*> used = fit.usedBands();
  for (const PatchGroup* band : used) {
    fit.patches += band->patches;
    fit.points += band->points;
  }
  if (used.empty()) {
    throw InputError(fmt::format(
        "{}: no band of ranges has at least {} flat patches of {} x {} beams with incidences up to {:g} deg: "
        "noise is measured on flat surfaces such as walls and floors; give more scans, or scans of a "
        "place with such surfaces{}",
        shortList(fit.files, kMostFiles), kFewestPatches, kPatchRings, kPatchColumns, kMostIncidenceDegrees,
        beams.rings < kPatchRings ? fmt::format("; and a sensor of at least {} rings", kPatchRings) : ""));
  }
  fitLine(fit, used);
  FlatPatches usedPatches;
  for (const FlatPatch* p : steep) {
    // The mean range of a band lies in the band and thus identifies it.
    const bool isUsed = std::ranges::any_of(
        used, [&](const PatchGroup* band) { return rangeBandOf(band->range) == rangeBandOf(p->range); });
    if (isUsed) usedPatches.push_back(p);
  }
  constexpr std::uint32_t kDropOutStream = 1000;  // above the stream numbers of the bands, see measureBands()
  fit.dropOut = dropOutOf(usedPatches, kDropOutStream);
  // Grazing views of level ground tell errors of the rings' elevations from those of their ranges.
  FlatPatches ringPatches = usedPatches;
  for (const FlatPatch& p : patches) {
    if (p.incidence < kSteep && std::abs(normalized(p.plane).z) > kLeastLevel) ringPatches.push_back(&p);
  }
  fit.rings = fitRingErrors(beams, scans, ringPatches);
  return fit;
}

std::vector<std::string> beyondMeasured(const NoiseFit& fit) {
  const PatchGroup& last = *fit.usedBands().back();
  if (!(fit.sensorReach > last.high)) return {};
  const char* rule = !fit.linear || fit.growth <= 0 ? "the last value is used" : "the line is extrapolated";
  std::vector<std::string> lines{
      fmt::format("Measured up to {:.0f} m; from there to {:g} m {}.", last.range, fit.sensorReach, rule)};
  for (const PatchGroup& band : fit.bands) {
    if (band.leftOut.empty() || band.range <= last.range || band.patches < kFewestPatches) continue;
    lines.push_back(fmt::format("At {} the noise is {:.0f} mm, which is left out of the fit ({}).", band.name,
                                1000 * band.sigma, band.leftOut));
  }
  return lines;
}

std::string effectsYaml(const NoiseFit& fit, const std::string& date) {
  const std::vector<const PatchGroup*> used = fit.usedBands();
  const PatchGroup* const first = used.front();
  const PatchGroup* const last = used.back();
  std::string rows;
  for (const PatchGroup* band : used) {
    rows += fmt::format("{}[{:.3g}, {:.3g}]", rows.empty() ? "" : ", ", band->range, band->sigma);
  }
  std::string text =
      fmt::format("  # Fitted with `scanmill fit-noise`, {}, on\n  # {}.\n", date, shortList(fit.files, kMostFiles));
  text += fmt::format(
      "  # {} flat patches with {} points, {:.3g} to {:.3g} m away and up to {:g} deg from their normals.\n",
      fit.patches, fit.points, first->range, last->range, kMostIncidenceDegrees);
  if (fit.dropOut.lost > 0) {
    text +=
        fmt::format("  # Beams lost among returns of flat patches: {} of {}.\n", fit.dropOut.lost, fit.dropOut.beams);
    text += fmt::format("  - dropout: {{probability: {:.2g}}}\n", fit.dropOut.share());
  } else {
    text +=
        fmt::format("  # No drop-out: none of {} beams was lost among returns of flat patches.\n", fit.dropOut.beams);
  }
  text += ringBiasYaml(fit.rings);
  for (const std::string& line : beyondMeasured(fit)) text += fmt::format("  # {}\n", line);
  if (fit.linear) {
    // A line through two bands or fewer always fits, so the fit does not test the model.
    std::string agreement = fmt::format("chi^2 {:.3g} for {:.0f} degrees of freedom", fit.chiSquare, fit.freedom);
    if (fit.freedom <= 0) {
      agreement = first == last ? "one band of ranges cannot show growth" : "two bands of ranges cannot test a line";
    }
    text += fmt::format("  # Errors: {:.1g} m and {:.1g} m/m; {}.\n", fit.baseError, fit.growthError, agreement);
    text += fmt::format("  - range_noise: {{sigma_m: {:.3g}, sigma_per_m: {:.3g}}}\n", fit.base, fit.growth);
  } else {
    text += fmt::format(
        "  # A line does not fit (chi^2 {:.3g} for {:.0f} degrees of freedom, off by up to {:.0f} %): the bands "
        "themselves.\n",
        fit.chiSquare, fit.freedom, 100 * fit.largestMisfit);
    text += fmt::format("  - range_noise: {{table: [{}]}}\n", rows);
  }
  if (fit.step > 0) text += fmt::format("  - quantize: {{step_m: {:.5g}}}\n", fit.step);
  return text;
}

std::string withEffects(const std::string& text, const std::string& file, const std::string& effects) {
  const Value root = parseYaml(text, file);
  expectKind(root, FileKind::Sensor);
  if (root.kind != Value::Kind::Map || root.entries.empty()) throw InputError({file}, "is not a sensor file");
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start != std::string::npos && root.where.line > 0 && text[start] == '{') {
    throw InputError(root.where, "is written as {...}: give each key a line of its own");
  }
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  // Lines from the key `effects` up to the next key; if `effects` is absent, an empty span at the file's end.
  LineSpan key{lines.size(), lines.size()};
  for (const Value::Entry& entry : root.entries) {
    const auto line = static_cast<std::size_t>(entry.value.keyLine - 1);
    if (entry.key == "effects") {
      key.first = line;
    } else if (key.first < lines.size() && line > key.first) {
      key.end = std::min(key.end, line);
    }
  }
  // A blank line or a comment without indentation between two keys may belong to the second key.
  while (key.end > key.first && (trimmed(lines[key.end - 1]).empty() || lines[key.end - 1].front() == '#')) --key.end;
  const Value* const list = root.find("effects");
  const bool isBlockList = list != nullptr && list->kind == Value::Kind::Sequence && !list->items.empty() &&
                           list->items.front().where.line > static_cast<int>(key.first) + 1;
  const std::string kept = isBlockList ? keptEffects(*list, lines, key, effects) : "";
  const std::string keyLine = "effects:\n";
  return linesOf(lines, {0, key.first}) + (kept.empty() ? effects : keyLine + kept + effects.substr(keyLine.size())) +
         linesOf(lines, {key.end, lines.size()});
}

}  // namespace scanmill
