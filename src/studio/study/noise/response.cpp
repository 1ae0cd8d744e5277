#include "study/noise/response.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>

#include "base/error.h"
#include "evaluate/spread.h"

namespace scanmill {

namespace {

constexpr std::array<double, 9> kBands{2, 4, 8, 12, 20, 30, 45, 70, 120};  // m, edges of the bands of ranges
constexpr std::size_t kFewestInCell = 9;                                   // returns in a cell
constexpr std::size_t kFewestSurfaces = 200;                               // cells of all scans
constexpr std::size_t kFewestOfKind = 30;  // cells or returns of one kind that are compared
constexpr double kReference = 10;          // m, range at which a white target has the power 1

// A band of ranges (index into kBands) and whether the surface is ground.
using SurfaceKind = std::pair<std::size_t, bool>;

struct SurfaceReturn {
  double range = 0;
  double number = 0;  // recorded intensity or simulated power
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

// Returns the height of the ground (m) below the sensor, as the most frequent height of the returns from 5 to 15 m.
double groundHeight(const Scan& scan) {
  constexpr double kStep = 0.1;  // m
  std::map<long, std::size_t> counts;
  for (const Vec3f& p : scan.position) {
    const double r = length(Vec3d(p));
    if (r > 5 && r < 15) ++counts[std::lround(p.z / kStep)];
  }
  const auto most = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
  return most == counts.end() ? 0 : kStep * static_cast<double>(most->first);
}

void collect(const Scan& scan, const std::vector<float>& numbers, Surfaces& found) {
  const double ground = groundHeight(scan);
  std::unordered_map<std::uint64_t, SurfaceCell> cells;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Vec3d p(scan.position[i]);
    const double range = length(p);
    const std::optional<std::size_t> band = isFinite(p) ? bandOf(range) : std::nullopt;
    if (!band || !std::isfinite(numbers[i])) continue;
    const SurfaceKind kind{*band, std::abs(p.z - ground) < 0.3 + 0.03 * range};
    const auto part = [](double v) { return static_cast<std::uint64_t>(std::floor(v / kSurfaceCell)) & 0x1fffffu; };
    SurfaceCell& cell = cells[part(p.x) << 42 | part(p.y) << 21 | part(p.z)];
    if (cell.samples.empty()) cell.kind = kind;
    const SurfaceReturn sample{range, double{numbers[i]}};
    cell.samples.push_back(sample);
    found.returns[kind].push_back(sample);
  }
  std::vector<std::pair<std::uint64_t, SurfaceCell>> sorted(cells.begin(), cells.end());
  std::ranges::sort(sorted, {}, [](const auto& entry) { return entry.first; });
  for (auto& [key, cell] : sorted) {
    if (cell.samples.size() >= kFewestInCell) found.cells.push_back(std::move(cell));
  }
}

// A value with the weight that it has in a distribution.
struct Weighted {
  double value = 0, weight = 1;
};

// Values in ascending order, with the share of the weight below the middle of each.
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

  // Returns the quantile `share`, from 0 to 1, linear between the values.
  double quantile(double share) const {
    const auto above = std::ranges::lower_bound(share_, share) - share_.begin();
    if (above == 0) return values_.front().value;
    if (above == static_cast<std::ptrdiff_t>(share_.size())) return values_.back().value;
    const auto k = static_cast<std::size_t>(above);
    const double part = (share - share_[k - 1]) / (share_[k] - share_[k - 1]);
    return values_[k - 1].value + part * (values_[k].value - values_[k - 1].value);
  }
  // Returns the share of the weight that values of 0 have.
  double zeros() const {
    double sum = 0, all = 0;
    for (const Weighted& v : values_) {
      all += v.weight;
      if (v.value <= 0) sum += v.weight;
    }
    return sum / all;
  }

 private:
  std::vector<Weighted> values_;
  std::vector<double> share_;
};

// Returns the step of which nearly all numbers are multiples; 0: there is none.
double stepOf(const std::vector<double>& numbers) {
  std::vector<double> values = numbers;
  std::ranges::sort(values);
  const double least = 1e-5 * std::max(1.0, values.back());  // closer numbers are equal but for rounding
  double step = INFINITY;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] - values[i - 1] > least) step = std::min(step, values[i] - values[i - 1]);
  }
  if (!std::isfinite(step) || step < 10 * least) return 0;
  // Refines the step by the largest number, which is many steps long.
  step = values.back() / std::round(values.back() / step);
  const auto fits =
      std::ranges::count_if(values, [&](double v) { return std::abs(v - step * std::round(v / step)) < 0.05 * step; });
  return static_cast<double>(fits) >= 0.99 * static_cast<double>(values.size()) ? step : 0;
}

double powerAtReference(const SurfaceReturn& s) {
  return s.number * (s.range / kReference) * (s.range / kReference);
}

double valueOf(const SurfaceReturn& s, double floor, bool reflectivity) {
  const double above = std::max(0.0, s.number - floor);
  return reflectivity ? powerAtReference({s.range, above}) : above;
}

// An intensity is 0 if the power is not above `floor`, or if the value, without the floor, is not above `dark`.
struct Darkness {
  double floor = 0, dark = 0;
};

// Returns the pair that gives each kind of surface its share of recorded zeros, by least squares over all returns.
// Faint echoes, which are far, are told from dark surfaces, which are near too, by the ranges. Among pairs that are
// nearly equally good the smallest numbers are returned.
Darkness darknessOf(const Surfaces& recorded, const Surfaces& simulated, bool reflectivity) {
  constexpr std::size_t kTested = 2000;  // simulated returns of each kind
  constexpr double kBetter = 0.98;       // ratio of sums of squares, for larger numbers
  struct Group {
    double zeros = 0, weight = 0;
    std::vector<SurfaceReturn> echoes;
  };
  std::vector<Group> groups;
  double zeros = 0, count = 0;
  for (const auto& [kind, returns] : recorded.returns) {
    const auto same = simulated.returns.find(kind);
    if (same == simulated.returns.end() || std::min(returns.size(), same->second.size()) < kFewestOfKind) continue;
    Group group;
    group.weight = static_cast<double>(returns.size());
    for (const SurfaceReturn& s : returns) group.zeros += s.number <= 0 ? 1 / group.weight : 0;
    const std::size_t every = 1 + same->second.size() / kTested;
    for (std::size_t i = 0; i < same->second.size(); i += every) group.echoes.push_back(same->second[i]);
    zeros += group.zeros * group.weight;
    count += group.weight;
    groups.push_back(std::move(group));
  }
  constexpr double kFewest = 0.002;  // a smaller share of zeros tells nothing
  if (zeros < kFewest * count) return {};
  const auto misfit = [&](const Darkness& d) {
    double sum = 0;
    for (const Group& group : groups) {
      const auto none = std::ranges::count_if(
          group.echoes, [&](const SurfaceReturn& s) { return valueOf(s, d.floor, reflectivity) <= d.dark; });
      const double difference = static_cast<double>(none) / static_cast<double>(group.echoes.size()) - group.zeros;
      sum += group.weight * difference * difference;
    }
    return sum;
  };
  std::vector<double> floors{0}, darks{0};
  for (int k = 0; k < 66; ++k) floors.push_back(1e-4 * std::pow(1.15, k));  // up to 1
  // If powers are reported, dark values and the floor are the same.
  for (int k = 0; reflectivity && k < 26; ++k) darks.push_back(1e-3 * std::pow(1.25, k));  // up to 0.3
  Darkness best;
  double least = INFINITY;
  for (const double dark : darks) {
    for (const double floor : floors) {
      const double sum = misfit({floor, dark});
      if (sum >= kBetter * least) continue;
      least = sum;
      best = {floor, dark};
    }
  }
  return best;
}

double medianNumber(const SurfaceCell& cell) {
  std::vector<double> numbers;
  for (const SurfaceReturn& s : cell.samples) numbers.push_back(s.number);
  return medianOf(std::move(numbers));
}

double medianValue(const SurfaceCell& cell, double floor, bool reflectivity) {
  std::vector<double> values;
  for (const SurfaceReturn& s : cell.samples) values.push_back(valueOf(s, floor, reflectivity));
  return medianOf(std::move(values));
}

// Returns the intensity of a value, as the effect `intensity` computes it from a table.
double respond(const std::vector<std::pair<double, double>>& table, double value) {
  if (value <= 0) return 0;
  if (value <= table.front().first) return table.front().second;
  for (std::size_t k = 1; k < table.size(); ++k) {
    const auto& [low, before] = table[k - 1];
    const auto& [high, after] = table[k];
    if (value <= high) return before + (after - before) * std::log(value / low) / std::log(high / low);
  }
  return table.back().second;
}

// Returns the weight of each kind of simulated surface: how many recorded surfaces one of them stands for.
std::map<SurfaceKind, double> weightsOf(const Surfaces& recorded, const Surfaces& simulated) {
  std::map<SurfaceKind, double> here, there;
  for (const SurfaceCell& c : recorded.cells) ++here[c.kind];
  for (const SurfaceCell& c : simulated.cells) ++there[c.kind];
  std::map<SurfaceKind, double> weights;
  for (const auto& [kind, count] : here) {
    const auto same = there.find(kind);
    if (same == there.end() || std::min(count, same->second) < kFewestOfKind) continue;
    weights[kind] = count / same->second;
  }
  return weights;
}

// Adds a pair to the table if both of its numbers rise.
void append(std::vector<std::pair<double, double>>& table, double value, double number) {
  constexpr double kApart = 1.1;  // ratio of two values of the table
  if (!(value > 0)) return;
  if (!table.empty() && (value < kApart * table.back().first || number <= table.back().second)) return;
  table.emplace_back(value, number);
}

// Replaces values by the nearest ones, in the least squares, that do not fall (pool adjacent violators; Ayer et al.,
// "An empirical distribution function for sampling with incomplete information", 1955).
void makeRise(std::vector<double>& values) {
  std::vector<std::pair<double, std::size_t>> pools;  // mean and number of values
  for (const double v : values) {
    pools.emplace_back(v, 1);
    while (pools.size() > 1 && pools[pools.size() - 2].first > pools.back().first) {
      const auto [mean, count] = pools.back();
      pools.pop_back();
      auto& [other, others] = pools.back();
      other = (other * static_cast<double>(others) + mean * static_cast<double>(count)) /
              static_cast<double>(others + count);
      others += count;
    }
  }
  values.clear();
  for (const auto& [mean, count] : pools) values.insert(values.end(), count, mean);
}

// Changes the intensities of a table as little as possible so that they grow at most in proportion to the value, as
// those of receivers do: recorded surfaces whose reflectances differ more than those of the simulated ones must not
// make the response steeper than that. Alternates between both conditions (Dykstra, "An algorithm for restricted least
// squares regression", 1983).
void limitSlope(std::vector<std::pair<double, double>>& table) {
  const auto first =
      static_cast<std::size_t>(std::ranges::count_if(table, [](const auto& row) { return row.second <= 0; }));
  std::vector<double> rising, logs;
  for (std::size_t k = first; k < table.size(); ++k) {
    logs.push_back(std::log(table[k].first));
    rising.push_back(std::log(table[k].second));
  }
  constexpr int kRounds = 500;
  std::vector<double> byRise(rising.size(), 0.0), bySlope(rising.size(), 0.0);  // corrections of both steps
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> next = rising;
    for (std::size_t k = 0; k < next.size(); ++k) next[k] += byRise[k];
    std::vector<double> made = next;
    makeRise(made);
    for (std::size_t k = 0; k < next.size(); ++k) byRise[k] = next[k] - made[k];
    next = made;
    for (std::size_t k = 0; k < next.size(); ++k) next[k] += bySlope[k];
    std::vector<double> below(next.size());  // must rise as well: the value's logarithm less the intensity's
    for (std::size_t k = 0; k < next.size(); ++k) below[k] = logs[k] - next[k];
    makeRise(below);
    for (std::size_t k = 0; k < next.size(); ++k) {
      rising[k] = logs[k] - below[k];
      bySlope[k] = next[k] - rising[k];
    }
  }
  for (std::size_t k = first; k < table.size(); ++k) table[k].second = std::exp(rising[k - first]);
}

// Sets the table and the slope of a fit with known `floor` and `reflectivity`. `dark`: value that has the intensity 0.
void fillTable(const Surfaces& recorded, const Surfaces& simulated, const std::map<SurfaceKind, double>& weights,
               double dark, ResponseFit& fit) {
  const double floor = fit.floor;
  const bool reflectivity = fit.reflectivity;
  std::vector<std::pair<double, double>>& table = fit.table;
  table.clear();
  std::vector<Weighted> numbers, values;
  for (const SurfaceCell& c : recorded.cells) {
    if (weights.contains(c.kind)) numbers.push_back({medianNumber(c)});
  }
  for (const SurfaceCell& c : simulated.cells) {
    const auto weight = weights.find(c.kind);
    if (weight != weights.end()) values.push_back({medianValue(c, floor, reflectivity), weight->second});
  }
  const Distribution here(std::move(numbers));
  const Distribution there(std::move(values));
  const double zeros = here.zeros();
  append(table, dark, 0);
  for (const double share : {0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.9, 0.97, 0.99}) {
    if (share > zeros) append(table, there.quantile(share), here.quantile(share));
  }
  // The brightest returns come from small things, such as signs and plates, which fill no cell.
  std::vector<Weighted> brightHere, brightThere;
  for (const auto& [kind, weight] : weights) {
    const std::vector<SurfaceReturn>& mine = recorded.returns.at(kind);
    const std::vector<SurfaceReturn>& theirs = simulated.returns.at(kind);
    for (const SurfaceReturn& s : mine) brightHere.push_back({s.number});
    const double each = static_cast<double>(mine.size()) / static_cast<double>(theirs.size());
    for (const SurfaceReturn& s : theirs) brightThere.push_back({valueOf(s, floor, reflectivity), each});
  }
  const Distribution allHere(std::move(brightHere));
  const Distribution allThere(std::move(brightThere));
  constexpr double kBrightest = 0.9997;  // beyond what noise alone makes bright
  append(table, allThere.quantile(kBrightest), allHere.quantile(kBrightest));
  limitSlope(table);
  const double low = there.quantile(0.25), high = there.quantile(0.75);
  if (low > 0 && high > low && respond(table, low) > 0) {
    fit.slope = std::log(respond(table, high) / respond(table, low)) / std::log(high / low);
  }
}

struct KindMedians {
  std::vector<double> recorded, simulated;
};

double misfitOf(const Surfaces& recorded, const Surfaces& simulated, const std::map<SurfaceKind, double>& weights,
                const ResponseFit& fit) {
  std::map<SurfaceKind, KindMedians> medians;
  for (const SurfaceCell& c : recorded.cells) medians[c.kind].recorded.push_back(medianNumber(c));
  for (const SurfaceCell& c : simulated.cells) {
    medians[c.kind].simulated.push_back(respond(fit.table, medianValue(c, fit.floor, fit.reflectivity)));
  }
  double sum = 0, count = 0;
  for (const auto& [kind, weight] : weights) {
    const KindMedians& of = medians.at(kind);
    const double difference = medianOf(of.recorded) - medianOf(of.simulated);
    sum += difference * difference * static_cast<double>(of.recorded.size());
    count += static_cast<double>(of.recorded.size());
  }
  std::vector<double> numbers;
  for (const SurfaceCell& c : recorded.cells) numbers.push_back(medianNumber(c));
  return std::sqrt(sum / count) / (quantileOf(numbers, 0.95) - quantileOf(numbers, 0.05));
}

// Returns the standard deviation that intensities have within a cell, as the median over all cells without zeros.
// `number`: maps a sample to its intensity.
template <class Number>
double scatterOf(const std::vector<SurfaceCell>& cells, const Number& number) {
  std::vector<double> deviations;
  for (const SurfaceCell& cell : cells) {
    double sum = 0, squares = 0;
    bool dark = false;
    for (const SurfaceReturn& s : cell.samples) {
      const double v = number(s);
      dark |= v <= 0;
      sum += v;
      squares += v * v;
    }
    const auto n = static_cast<double>(cell.samples.size());
    if (!dark) deviations.push_back(std::sqrt(std::max(0.0, squares - sum * sum / n) / (n - 1)));
  }
  return medianOf(std::move(deviations));
}

}  // namespace

ResponseFit fitResponse(const std::vector<Scan>& recorded, const std::vector<Scan>& simulated) {
  Surfaces mine, theirs;
  std::vector<double> numbers;
  for (const Scan& scan : recorded) {
    if (scan[kIntensity].size() != scan.size()) {
      throw InputError("a recorded scan has no intensities, so its sensor's response cannot be found");
    }
    collect(scan, scan[kIntensity], mine);
    for (const float v : scan[kIntensity]) {
      if (std::isfinite(v)) numbers.push_back(double{v});
    }
  }
  for (const Scan& scan : simulated) {
    if (scan[kPower].size() != scan.size()) {
      throw InputError("the simulated scans have no powers: generate them with `power` among `output.columns`");
    }
    collect(scan, scan[kPower], theirs);
  }
  const std::map<SurfaceKind, double> weights = weightsOf(mine, theirs);
  if (std::min(mine.cells.size(), theirs.cells.size()) < kFewestSurfaces || weights.empty()) {
    throw InputError(fmt::format(
        "too few surfaces to find the response: {} recorded and {} simulated cells of {} m with at least {} "
        "returns, but {} are needed: give more scans",
        mine.cells.size(), theirs.cells.size(), kSurfaceCell, kFewestInCell, kFewestSurfaces));
  }
  ResponseFit fit;
  fit.recorded = mine.cells.size();
  fit.simulated = theirs.cells.size();
  const auto [least, most] = std::ranges::minmax(numbers);
  if (least == most) throw InputError("the recorded intensities are all alike, so there is no response to find");
  fit.bytes = most > 1 && most <= 255 && std::ranges::all_of(numbers, [](double v) { return v == std::floor(v); });
  const double fullScale = fit.bytes ? 255 : 1;
  const double step = stepOf(numbers);
  if (!fit.bytes || step > 1) fit.step = step / fullScale;
  for (const bool reflectivity : {true, false}) {
    ResponseFit one = fit;
    one.reflectivity = reflectivity;
    const Darkness darkness = darknessOf(mine, theirs, reflectivity);
    one.floor = darkness.floor;
    fillTable(mine, theirs, weights, darkness.dark, one);
    if (one.table.size() < 2) {
      throw InputError("the intensities of the recorded surfaces are too much alike to find the response");
    }
    one.misfit = misfitOf(mine, theirs, weights, one);
    if (reflectivity) {
      fit = std::move(one);
    } else if (one.misfit < fit.misfit) {
      one.otherMisfit = fit.misfit;
      fit = std::move(one);
    } else {
      fit.otherMisfit = one.misfit;
    }
  }
  // The receiver's noise is the scatter that the simulated scans do not have.
  const double here = scatterOf(mine.cells, [](const SurfaceReturn& s) { return s.number; });
  const double there = scatterOf(theirs.cells, [&](const SurfaceReturn& s) {
    return respond(fit.table, valueOf(s, fit.floor, fit.reflectivity));
  });
  fit.noise = std::sqrt(std::max(0.0, here * here - there * there)) / fullScale;
  return fit;
}

std::string responseYaml(const ResponseFit& fit, const std::string& diffuse, const std::string& source) {
  std::string rows;
  for (const auto& [value, number] : fit.table) {
    rows += fmt::format("{}[{:.3g}, {:.4g}]", rows.empty() ? "" : ", ", value, number);
  }
  std::string text = fmt::format(
      "  # The response: {} recorded cells of {} m are as bright, in the same order, as {} simulated ones of\n"
      "  # {}. The misfit of medians of ground and other surfaces in bands of ranges is {:.1f} % of the span\n"
      "  # that nine tenths of the recorded surfaces have; {} for the range it would be {:.1f} %.\n"
      "  # The last value is that of the brightest returns; between it and the one before nothing was measured.\n",
      fit.recorded, kSurfaceCell, fit.simulated, source, 100 * fit.misfit,
      fit.reflectivity ? "not corrected" : "corrected", 100 * fit.otherMisfit);
  text += fmt::format("  - intensity:\n      model: {}\n", fit.reflectivity ? "reflectivity" : "power");
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
