#include "study/noise/response.h"

#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "base/error.h"
#include "evaluate/spread.h"

namespace scanmill {

namespace {

constexpr std::array<double, 9> kBands{2, 4, 8, 12, 20, 30, 45, 70, 120};  // m, edges of the bands of ranges
constexpr std::size_t kFewestInCell = 9;      // least number of returns in a cell that is used
constexpr std::size_t kFewestSurfaces = 200;  // least number of used cells of all scans
constexpr std::size_t kFewestOfKind = 30;     // least number of cells or returns of one kind that are compared
constexpr double kReference = 10;             // m, range at which a white target has the power 1

using ResponseTable = std::vector<std::pair<double, double>>;  // ResponseFit::table

// A band of ranges (index into kBands) and whether the surface is ground.
using SurfaceKind = std::pair<std::size_t, bool>;

struct SurfaceReturn {
  double range = 0;
  double measured = 0;  // recorded intensity or simulated power
};

struct SurfaceCell {
  SurfaceKind kind;
  std::vector<SurfaceReturn> samples;
};

// The returns of all scans, by kind, and the cells with enough returns.
struct Surfaces {
  std::map<SurfaceKind, std::vector<SurfaceReturn>> returns;
  std::vector<SurfaceCell> cells;
};

std::optional<std::size_t> bandOf(double range) {
  if (range < kBands.front() || range >= kBands.back()) return std::nullopt;
  return static_cast<std::size_t>(std::ranges::upper_bound(kBands, range) - kBands.begin()) - 1;
}

// Returns the ground's z (m): the most frequent z of the returns near the sensor; 0 if no return is near.
double groundHeight(const Scan& scan) {
  constexpr double kStep = 0.1, kNearest = 5, kFarthest = 15;  // m: step of heights; ranges of the counted returns
  std::map<long, std::size_t> counts;
  for (const Vec3f& p : scan.position) {
    const double range = length(Vec3d(p));
    if (range > kNearest && range < kFarthest) ++counts[std::lround(p.z / kStep)];
  }
  const auto mostFrequent = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
  return mostFrequent == counts.end() ? 0 : kStep * static_cast<double>(mostFrequent->first);
}

// Adds the returns and cells of a scan to `surfaces`. `measured`: the intensity or power of each point. A cell has the
// kind of its first return.
void addSurfaces(const Scan& scan, const std::vector<float>& measured, Surfaces& surfaces) {
  constexpr double kGroundSlack = 0.3, kGroundSlope = 0.03;  // height difference (m), and its growth per m of range
  const double ground = groundHeight(scan);
  const auto cellIndex = [](double v) { return static_cast<std::uint64_t>(std::floor(v / kSurfaceCell)) & 0x1fffffu; };
  std::map<std::uint64_t, SurfaceCell> cells;  // the key consists of the indices along x, y and z, with 21 bits each
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3d p(scan.position[i]);
    const double range = length(p);
    const std::optional<std::size_t> band = isFinite(p) ? bandOf(range) : std::nullopt;
    if (!band || !std::isfinite(measured[i])) continue;
    const SurfaceKind kind{*band, std::abs(p.z - ground) < kGroundSlack + kGroundSlope * range};
    SurfaceCell& cell = cells[cellIndex(p.x) << 42 | cellIndex(p.y) << 21 | cellIndex(p.z)];
    if (cell.samples.empty()) cell.kind = kind;
    cell.samples.push_back({range, double{measured[i]}});
    surfaces.returns[kind].push_back(cell.samples.back());
  }
  for (auto& [key, cell] : cells) {
    if (cell.samples.size() >= kFewestInCell) surfaces.cells.push_back(std::move(cell));
  }
}

// A value and its weight in a distribution.
struct Weighted {
  double value = 0, weight = 1;
};

// A distribution of weighted values: the values in ascending order, with the cumulative share of the weight.
class Distribution {
 public:
  explicit Distribution(std::vector<Weighted> values) : values_(std::move(values)) {
    std::ranges::sort(values_, {}, &Weighted::value);
    double sum = 0;
    for (const Weighted& v : values_) sum += v.weight;
    double before = 0;
    for (const Weighted& v : values_) {
      share_.push_back((before + v.weight / 2) / sum);
      before += v.weight;
    }
  }

  // Returns the quantile `share` (0 to 1), interpolated linearly. The distribution must have values.
  double quantile(double share) const {
    const auto k = static_cast<std::size_t>(std::ranges::lower_bound(share_, share) - share_.begin());
    if (k == 0) return values_.front().value;
    if (k == share_.size()) return values_.back().value;
    const double fraction = (share - share_[k - 1]) / (share_[k] - share_[k - 1]);
    return values_[k - 1].value + fraction * (values_[k].value - values_[k - 1].value);
  }

 private:
  std::vector<Weighted> values_;
  std::vector<double> share_;  // cumulative share of the weight at each value, with half of the value's own weight
};

// Returns the step of which nearly all values are multiples; 0 if there is no such step. `values`: not empty.
double stepOf(std::vector<double> values) {
  constexpr double kRounding = 1e-5;    // values that differ by less, relative to the largest, are equal
  constexpr double kTolerance = 0.05;   // largest deviation of a value from a multiple of the step, in steps
  constexpr double kLeastShare = 0.99;  // fraction of the values that must be multiples of the step
  std::ranges::sort(values);
  const double leastGap = kRounding * std::max(1.0, values.back());
  double step = INFINITY;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] - values[i - 1] > leastGap) step = std::min(step, values[i] - values[i - 1]);
  }
  if (!std::isfinite(step) || step < 10 * leastGap) return 0;
  // Refines the step by the largest value, which is many steps long.
  step = values.back() / std::round(values.back() / step);
  const auto multiples = std::ranges::count_if(
      values, [&](double v) { return std::abs(v - step * std::round(v / step)) < kTolerance * step; });
  return static_cast<double>(multiples) >= kLeastShare * static_cast<double>(values.size()) ? step : 0;
}

// Returns the value from which a sensor with this model computes the intensity of a simulated return: the power above
// `floor`, corrected for the range if the model is Reflectivity.
double valueOf(const SurfaceReturn& s, double floor, ResponseModel model) {
  const double power = std::max(0.0, s.measured - floor);
  return model == ResponseModel::Power ? power : power * (s.range / kReference) * (s.range / kReference);
}

// An intensity is 0 if the power is at most `floor`, or if valueOf() with this floor is at most `dark`.
struct Darkness {
  double floor = 0, dark = 0;
};

// The returns of one kind of surface, recorded and simulated.
struct KindReturns {
  double zeroShare = 0;  // share of the recorded intensities that are 0
  double recorded = 0;   // number of recorded returns
  std::vector<SurfaceReturn> simulated;
};

// Returns the kinds with enough returns in both sets; keeps at most about kMostReturns simulated returns per kind.
std::vector<KindReturns> commonKinds(const Surfaces& recorded, const Surfaces& simulated) {
  constexpr std::size_t kMostReturns = 2000;  // limits the time
  std::vector<KindReturns> kinds;
  for (const auto& [kind, returns] : recorded.returns) {
    const auto found = simulated.returns.find(kind);
    if (found == simulated.returns.end() || std::min(returns.size(), found->second.size()) < kFewestOfKind) continue;
    KindReturns& common = kinds.emplace_back();
    common.recorded = static_cast<double>(returns.size());
    for (const SurfaceReturn& s : returns) common.zeroShare += s.measured <= 0 ? 1 / common.recorded : 0;
    const std::size_t stride = 1 + found->second.size() / kMostReturns;
    for (std::size_t i = 0; i < found->second.size(); i += stride) common.simulated.push_back(found->second[i]);
  }
  return kinds;
}

// Returns the value 0, followed by a geometric sequence: `count` values from `first` on with the ratio `factor`.
std::vector<double> zeroAndGeometric(double first, double factor, int count) {
  std::vector<double> values{0};
  for (int k = 0; k < count; ++k) values.push_back(first * std::pow(factor, k));
  return values;
}

// Returns the floor and the dark value with which the share of zeros in each kind of simulated surface is nearest to
// the recorded share, by least squares over all returns. Faint echoes are far, dark surfaces may be near; hence the
// ranges tell the two apart. A larger value must fit clearly better. Both are 0 if the recording has hardly any zeros.
Darkness darknessOf(const Surfaces& recorded, const Surfaces& simulated, ResponseModel model) {
  constexpr double kBetter = 0.98;  // a larger floor or dark value must reduce the sum of squares by this factor
  constexpr double kLeastZeroShare = 0.002;
  const std::vector<KindReturns> kinds = commonKinds(recorded, simulated);
  double zeros = 0, returns = 0;
  for (const KindReturns& kind : kinds) {
    zeros += kind.zeroShare * kind.recorded;
    returns += kind.recorded;
  }
  if (zeros < kLeastZeroShare * returns) return {};
  const auto squaresOf = [&](const Darkness& tried) {
    double squares = 0;
    for (const KindReturns& kind : kinds) {
      const auto dark = std::ranges::count_if(
          kind.simulated, [&](const SurfaceReturn& s) { return valueOf(s, tried.floor, model) <= tried.dark; });
      const double difference = static_cast<double>(dark) / static_cast<double>(kind.simulated.size()) - kind.zeroShare;
      squares += kind.recorded * difference * difference;
    }
    return squares;
  };
  Darkness best;
  double least = INFINITY;
  // With the model Power, the dark value would have the same effect as the floor, so only the floor is searched.
  for (const double dark : zeroAndGeometric(1e-3, 1.25, model == ResponseModel::Power ? 0 : 26)) {  // up to 0.3
    for (const double floor : zeroAndGeometric(1e-4, 1.15, 66)) {                                   // up to 1
      const double squares = squaresOf({floor, dark});
      if (squares >= kBetter * least) continue;
      least = squares;
      best = {floor, dark};
    }
  }
  return best;
}

// Returns the median of figureOf(return) over the returns in a cell.
double medianIn(const SurfaceCell& cell, const auto& figureOf) {
  std::vector<double> figures;
  for (const SurfaceReturn& s : cell.samples) figures.push_back(figureOf(s));
  return medianOf(std::move(figures));
}

double medianIntensity(const SurfaceCell& cell) {
  return medianIn(cell, [](const SurfaceReturn& s) { return s.measured; });
}

double medianValue(const SurfaceCell& cell, double floor, ResponseModel model) {
  return medianIn(cell, [&](const SurfaceReturn& s) { return valueOf(s, floor, model); });
}

// Returns the intensity for a power or reflectivity, interpolated in the table as the effect `intensity` does.
double respond(const ResponseTable& table, double value) {
  if (value <= 0) return 0;
  if (value <= table.front().first) return table.front().second;
  for (std::size_t k = 1; k < table.size(); ++k) {
    const auto& [low, lowIntensity] = table[k - 1];
    const auto& [high, highIntensity] = table[k];
    if (value > high) continue;
    return lowIntensity + (highIntensity - lowIntensity) * std::log(value / low) / std::log(high / low);
  }
  return table.back().second;
}

// Returns, for each kind with enough surfaces in both sets, the number of recorded surfaces per simulated surface.
std::map<SurfaceKind, double> weightsOf(const Surfaces& recorded, const Surfaces& simulated) {
  std::map<SurfaceKind, double> recordedCells, simulatedCells;
  for (const SurfaceCell& c : recorded.cells) ++recordedCells[c.kind];
  for (const SurfaceCell& c : simulated.cells) ++simulatedCells[c.kind];
  std::map<SurfaceKind, double> weights;
  for (const auto& [kind, count] : recordedCells) {
    const auto found = simulatedCells.find(kind);
    if (found == simulatedCells.end() || std::min(count, found->second) < kFewestOfKind) continue;
    weights[kind] = count / found->second;
  }
  return weights;
}

// Adds a row if the intensity exceeds the last row's and the value is at least kApart times the last row's value.
void addRow(ResponseTable& table, double value, double intensity) {
  constexpr double kApart = 1.1;  // least ratio of two values of the table
  if (!(value > 0)) return;
  if (!table.empty() && (value < kApart * table.back().first || intensity <= table.back().second)) return;
  table.emplace_back(value, intensity);
}

// Returns the nondecreasing sequence with the least squared distance from the given values (pool adjacent violators;
// Ayer et al., "An empirical distribution function for sampling with incomplete information", 1955).
Eigen::ArrayXd rising(const Eigen::ArrayXd& values) {
  std::vector<std::pair<double, Eigen::Index>> pools;  // mean and number of values
  for (const double v : values) {
    pools.emplace_back(v, 1);
    while (pools.size() > 1 && pools[pools.size() - 2].first > pools.back().first) {
      const auto [mean, count] = pools.back();
      pools.pop_back();
      auto& [joinedMean, joinedCount] = pools.back();
      joinedMean = (joinedMean * static_cast<double>(joinedCount) + mean * static_cast<double>(count)) /
                   static_cast<double>(joinedCount + count);
      joinedCount += count;
    }
  }
  Eigen::ArrayXd result(values.size());
  Eigen::Index first = 0;
  for (const auto& [mean, count] : pools) {
    result.segment(first, count) = mean;
    first += count;
  }
  return result;
}

// Changes the intensities of a table as little as possible such that they grow at most in proportion to the value, as
// in real receivers. Otherwise the response would be too steep if reflectances vary more in the recorded scans than in
// the simulated ones. The conditions are that log(intensity) and log(value) - log(intensity) do not decrease; both are
// satisfied alternately (Dykstra, "An algorithm for restricted least squares regression", 1983).
void limitSlope(ResponseTable& table) {
  constexpr int kRounds = 500;  // number of alternations; chosen by eye
  const auto first = std::ranges::find_if(table, [](const auto& row) { return row.second > 0; });
  Eigen::ArrayXd values(table.end() - first), intensities(table.end() - first);  // logarithms
  std::transform(first, table.end(), values.begin(), [](const auto& row) { return std::log(row.first); });
  std::transform(first, table.end(), intensities.begin(), [](const auto& row) { return std::log(row.second); });
  // Corrections that Dykstra's algorithm keeps for the two conditions.
  Eigen::ArrayXd riseCorrection = Eigen::ArrayXd::Zero(values.size()), slopeCorrection = riseCorrection;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::ArrayXd rise = rising(intensities + riseCorrection);
    riseCorrection = (intensities + riseCorrection - rise).eval();
    intensities = values - rising(values - (rise + slopeCorrection));
    slopeCorrection = (rise + slopeCorrection - intensities).eval();
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(values.size()); ++k) {
    first[static_cast<std::ptrdiff_t>(k)].second = std::exp(intensities[static_cast<Eigen::Index>(k)]);
  }
}

double fullScaleOf(const ResponseFit& fit) {
  return fit.bytes ? 255 : 1;
}

// Sets the table and the slope of a fit whose `floor` and `model` are set. `weights`: the result of weightsOf().
// `dark`: value that has the intensity 0.
void fillTable(const Surfaces& recorded, const Surfaces& simulated, const std::map<SurfaceKind, double>& weights,
               double dark, ResponseFit& fit) {
  std::vector<Weighted> cellIntensities, cellValues, intensities, values;
  for (const SurfaceCell& c : recorded.cells) {
    if (weights.contains(c.kind)) cellIntensities.push_back({medianIntensity(c)});
  }
  for (const SurfaceCell& c : simulated.cells) {
    const auto weight = weights.find(c.kind);
    if (weight != weights.end()) cellValues.push_back({medianValue(c, fit.floor, fit.model), weight->second});
  }
  for (const auto& [kind, weight] : weights) {
    const std::vector<SurfaceReturn>&ofRecorded = recorded.returns.at(kind), &ofSimulated = simulated.returns.at(kind);
    for (const SurfaceReturn& s : ofRecorded) intensities.push_back({s.measured});
    const double returnWeight = static_cast<double>(ofRecorded.size()) / static_cast<double>(ofSimulated.size());
    for (const SurfaceReturn& s : ofSimulated) values.push_back({valueOf(s, fit.floor, fit.model), returnWeight});
  }
  const auto darkCells = std::ranges::count_if(cellIntensities, [](const Weighted& v) { return v.value <= 0; });
  const double darkShare = static_cast<double>(darkCells) / static_cast<double>(cellIntensities.size());
  const Distribution recordedCells(std::move(cellIntensities)), simulatedCells(std::move(cellValues));
  const Distribution recordedReturns(std::move(intensities)), simulatedReturns(std::move(values));
  addRow(fit.table, dark, 0);
  for (const double share : {0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.9, 0.97, 0.99}) {
    if (share > darkShare) addRow(fit.table, simulatedCells.quantile(share), recordedCells.quantile(share));
  }
  // The brightest returns come from small objects, such as signs and plates, which do not fill a cell.
  constexpr double kBrightest = 0.9997;  // quantile of the returns that is too high to be reached by noise alone
  addRow(fit.table, simulatedReturns.quantile(kBrightest), recordedReturns.quantile(kBrightest));
  limitSlope(fit.table);
  const double low = simulatedCells.quantile(0.25), high = simulatedCells.quantile(0.75);
  if (low > 0 && high > low && respond(fit.table, low) > 0) {
    fit.slope = std::log(respond(fit.table, high) / respond(fit.table, low)) / std::log(high / low);
  }
}

// Returns ResponseFit::misfit of a fit that has a table. `weights`: from weightsOf(); its kinds are compared.
double misfitOf(const Surfaces& recorded, const Surfaces& simulated, const std::map<SurfaceKind, double>& weights,
                const ResponseFit& fit) {
  std::map<SurfaceKind, std::vector<double>> ofRecorded, ofSimulated;  // medians of the cells
  std::vector<double> intensities;
  for (const SurfaceCell& c : recorded.cells) {
    intensities.push_back(medianIntensity(c));
    ofRecorded[c.kind].push_back(intensities.back());
  }
  for (const SurfaceCell& c : simulated.cells) {
    ofSimulated[c.kind].push_back(respond(fit.table, medianValue(c, fit.floor, fit.model)));
  }
  double sum = 0, count = 0;
  for (const auto& [kind, weight] : weights) {
    const auto cells = static_cast<double>(ofRecorded.at(kind).size());
    const double difference = medianOf(ofRecorded.at(kind)) - medianOf(ofSimulated.at(kind));
    sum += difference * difference * cells;
    count += cells;
  }
  return std::sqrt(sum / count) / (quantileOf(intensities, 0.95) - quantileOf(intensities, 0.05));
}

// Returns the median, over all cells without zeros, of the standard deviation of intensities in a cell. Cells have at
// least kFewestInCell returns. intensityOf(return) returns the intensity of a return.
double scatterOf(const std::vector<SurfaceCell>& cells, const auto& intensityOf) {
  std::vector<double> deviations;
  for (const SurfaceCell& cell : cells) {
    std::vector<double> intensities;
    intensities.reserve(cell.samples.size());
    for (const SurfaceReturn& s : cell.samples) intensities.push_back(intensityOf(s));
    if (std::ranges::min(intensities) > 0) deviations.push_back(deviationOf(intensities));
  }
  return medianOf(std::move(deviations));
}

// Sets `bytes` and `step` of the fit. Throws InputError if all intensities are equal.
void findScale(const std::vector<double>& intensities, ResponseFit& fit) {
  const auto [least, most] = std::ranges::minmax(intensities);
  if (least == most) throw InputError("the recorded intensities are all alike, so there is no response to find");
  fit.bytes = most > 1 && most <= 255 && std::ranges::all_of(intensities, [](double v) { return v == std::floor(v); });
  const double step = stepOf(intensities);
  if (!fit.bytes || step > 1) fit.step = step / fullScaleOf(fit);
}

}  // namespace

ResponseFit fitResponse(const std::vector<Scan>& recorded, const std::vector<Scan>& simulated) {
  Surfaces ofRecorded, ofSimulated;
  std::vector<double> intensities;
  for (const Scan& scan : recorded) {
    if (scan[kIntensity].size() != scan.size()) {
      throw InputError("a recorded scan has no intensities, so its sensor's response cannot be found");
    }
    addSurfaces(scan, scan[kIntensity], ofRecorded);
    for (const float v : scan[kIntensity]) {
      if (std::isfinite(v)) intensities.push_back(double{v});
    }
  }
  for (const Scan& scan : simulated) {
    if (scan[kPower].size() != scan.size()) {
      throw InputError("the simulated scans have no powers: generate them with `power` among `output.columns`");
    }
    addSurfaces(scan, scan[kPower], ofSimulated);
  }
  const std::map<SurfaceKind, double> weights = weightsOf(ofRecorded, ofSimulated);
  ResponseFit unfitted{.recorded = ofRecorded.cells.size(), .simulated = ofSimulated.cells.size()};
  if (std::min(unfitted.recorded, unfitted.simulated) < kFewestSurfaces || weights.empty()) {
    throw InputError(fmt::format(
        "too few surfaces to find the response: {} recorded and {} simulated cells of {} m with at least {} "
        "returns, but {} are needed: give more scans",
        unfitted.recorded, unfitted.simulated, kSurfaceCell, kFewestInCell, kFewestSurfaces));
  }
  findScale(intensities, unfitted);
  const auto fitted = [&](ResponseModel model) {
    ResponseFit fit = unfitted;
    fit.model = model;
    const Darkness darkness = darknessOf(ofRecorded, ofSimulated, model);
    fit.floor = darkness.floor;
    fillTable(ofRecorded, ofSimulated, weights, darkness.dark, fit);
    if (fit.table.size() < 2) {
      throw InputError("the intensities of the recorded surfaces are too much alike to find the response");
    }
    fit.misfit = misfitOf(ofRecorded, ofSimulated, weights, fit);
    return fit;
  };
  const ResponseFit byReflectivity = fitted(ResponseModel::Reflectivity), byPower = fitted(ResponseModel::Power);
  ResponseFit fit = byPower.misfit < byReflectivity.misfit ? byPower : byReflectivity;
  fit.otherMisfit = std::max(byPower.misfit, byReflectivity.misfit);
  // The receiver's noise is the part of the scatter that the simulated scans do not have.
  const double scatter = scatterOf(ofRecorded.cells, [](const SurfaceReturn& s) { return s.measured; });
  const double withoutNoise = scatterOf(
      ofSimulated.cells, [&](const SurfaceReturn& s) { return respond(fit.table, valueOf(s, fit.floor, fit.model)); });
  fit.noise = std::sqrt(std::max(0.0, scatter * scatter - withoutNoise * withoutNoise)) / fullScaleOf(fit);
  return fit;
}

std::string responseYaml(const ResponseFit& fit, const std::string& diffuse, const std::string& source) {
  std::string rows;
  for (const auto& [value, intensity] : fit.table) {
    rows += fmt::format("{}[{:.3g}, {:.4g}]", rows.empty() ? "" : ", ", value, intensity);
  }
  std::string text = fmt::format(
      "  # The response: {} recorded cells of {} m are as bright, in the same order, as {} simulated ones of\n"
      "  # {}. The misfit of medians of ground and other surfaces in bands of ranges is {:.1f} % of the span\n"
      "  # that nine tenths of the recorded surfaces have; {} for the range it would be {:.1f} %.\n"
      "  # The last value is that of the brightest returns; between it and the one before nothing was measured.\n",
      fit.recorded, kSurfaceCell, fit.simulated, source, 100 * fit.misfit,
      fit.model == ResponseModel::Reflectivity ? "not corrected" : "corrected", 100 * fit.otherMisfit);
  text += fmt::format("  - intensity:\n      model: {}\n",
                      fit.model == ResponseModel::Reflectivity ? "reflectivity" : "power");
  if (diffuse != "lambertian") text += fmt::format("      diffuse: {}\n", diffuse);
  if (fit.bytes) text += "      output: u8\n";
  text += fmt::format("      table: [{}]\n", rows);
  if (fit.floor <= 0)
    text += "      # No floor: the recording has hardly any intensities of 0, or they do not depend on the power.\n";
  if (fit.noise <= 0)
    text += "      # No noise: surfaces scatter no more in the recording than in the simulated scans.\n";
  if (fit.floor > 0) text += fmt::format("      floor: {:.2g}\n", fit.floor);
  if (fit.noise > 0) text += fmt::format("      noise: {:.2g}\n", fit.noise);
  if (fit.step > 0) text += fmt::format("      step: {:.4g}\n", fit.step);
  return text;
}

}  // namespace scanmill
