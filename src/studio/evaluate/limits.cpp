#include "evaluate/limits.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/error.h"
#include "config/fields.h"

namespace scanmill {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

enum class Kind {
  Length,     // upper limit (m)
  Amount,     // upper limit of a number without a unit
  Share,      // upper limit of a fraction from 0 to 1
  Agreement,  // lower limit of a fraction from 0 to 1
  Rate,       // lower limit (beams/s)
};

struct Limit {
  std::string_view key;  // name of the limit in files and messages
  Kind kind;
  std::optional<double> ErrorLimits::*allowed;
  double (*value)(const Candidate&);

  bool atLeast() const { return kind == Kind::Agreement || kind == Kind::Rate; }
};

// Returns the mean intensity error; NaN if beams hit but their intensities are unknown. NaN exceeds every limit.
double meanIntensity(const Candidate& c) {
  return c.errors.bothHit > 0 && c.errors.intensity.count == 0 ? kNaN : c.errors.intensity.mean;
}

double rate(const Candidate& c) {
  return c.secondsPerBeam >= 0 ? 1 / c.secondsPerBeam : kNaN;
}

constexpr std::array<Limit, 13> kLimits{{
    {"mean", Kind::Length, &ErrorLimits::mean, [](const Candidate& c) { return c.errors.range.mean; }},
    {"rms", Kind::Length, &ErrorLimits::rms, [](const Candidate& c) { return c.errors.range.rms; }},
    {"median", Kind::Length, &ErrorLimits::median, [](const Candidate& c) { return c.errors.range.median; }},
    {"p95", Kind::Length, &ErrorLimits::p95, [](const Candidate& c) { return c.errors.range.p95; }},
    {"p99", Kind::Length, &ErrorLimits::p99, [](const Candidate& c) { return c.errors.range.p99; }},
    {"p999", Kind::Length, &ErrorLimits::p999, [](const Candidate& c) { return c.errors.range.p999; }},
    {"max", Kind::Length, &ErrorLimits::max, [](const Candidate& c) { return c.errors.range.max; }},
    {"intensity", Kind::Amount, &ErrorLimits::intensity, meanIntensity},
    {"miss_rate", Kind::Share, &ErrorLimits::missRate, [](const Candidate& c) { return c.errors.missRate(); }},
    {"labels", Kind::Agreement, &ErrorLimits::labels, [](const Candidate& c) { return c.errors.labels(); }},
    {"classes", Kind::Agreement, &ErrorLimits::classes, [](const Candidate& c) { return c.errors.classAgreed(); }},
    {"instances", Kind::Agreement, &ErrorLimits::instances,
     [](const Candidate& c) { return c.errors.instanceAgreed(); }},
    {"min_rate", Kind::Rate, &ErrorLimits::minRate, rate},
}};

bool holds(const Limit& limit, double value, double allowed) {
  return limit.atLeast() ? value >= allowed : value <= allowed;
}

// Returns the factor by which a limit is exceeded; 1 if it is kept, infinity if the value is NaN. For agreements, the
// fractions that disagree are compared: 98 % instead of 99 % is a factor of 2. Limits and disagreements below 1e-6 are
// replaced by 1e-6 as divisors.
double excess(const Limit& limit, double value, double allowed) {
  constexpr double kLeast = 1e-6;
  if (holds(limit, value, allowed)) return 1;
  double factor = 1 + (value - allowed) / std::max(allowed, kLeast);
  if (limit.kind == Kind::Agreement) factor = 1 + (allowed - value) / std::max(1 - allowed, kLeast);
  if (limit.kind == Kind::Rate) factor = allowed / value;
  return std::isnan(factor) ? kInfinity : factor;
}

double largestExcess(const Candidate& candidate, const ErrorLimits& limits) {
  double most = 1;
  for (const Limit& limit : kLimits) {
    if (const auto& allowed = limits.*limit.allowed) {
      most = std::max(most, excess(limit, limit.value(candidate), *allowed));
    }
  }
  return most;
}

struct Unit {
  std::string_view name;
  double size = 1;
};

// Returns the unit in which messages state a value. Lengths are in millimetres if the limit is below one metre.
Unit unitOf(Kind kind, double allowed) {
  if (kind == Kind::Length) return allowed < 1 ? Unit{" mm", 1e-3} : Unit{" m"};
  if (kind == Kind::Rate) return {" million beams/s", 1e6};
  return kind == Kind::Amount ? Unit{} : Unit{" %", 0.01};
}

// Describes an exceeded limit. The value is written with three digits, or with more if these are needed to show that
// the limit is exceeded.
std::string brokenText(const Limit& limit, double value, double allowed) {
  const Unit unit = unitOf(limit.kind, allowed);
  const std::string bound = limit.atLeast()
                                ? fmt::format("but at least {:.9g}{} are required", allowed / unit.size, unit.name)
                                : fmt::format("but at most {:.9g}{} are allowed", allowed / unit.size, unit.name);
  if (std::isnan(value)) return fmt::format("{} is unknown, {}", limit.key, bound);
  std::string figure;
  for (int digits = 3; digits <= 17; ++digits) {
    figure = fmt::format("{:.{}g}", value / unit.size, digits);
    if (!holds(limit, std::strtod(figure.c_str(), nullptr) * unit.size, allowed)) break;
  }
  return fmt::format("{} {}{}, {}", limit.key, figure, unit.name, bound);
}

struct Quantity {
  double number = 0;
  std::string unit;  // text of the unit, without blanks before it; empty: no unit
};

// Splits `value` into a finite number and the following text, which is the unit. Returns nothing if the value does not
// start with a finite number.
std::optional<Quantity> quantityOf(const Value& value) {
  if (value.kind != Value::Kind::Scalar) return std::nullopt;
  const std::string_view text = value.text;
  Quantity q;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), q.number);
  if (error != std::errc() || !std::isfinite(q.number)) return std::nullopt;
  std::string_view rest = text.substr(static_cast<std::size_t>(stop - text.data()));
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  q.unit = rest;
  return q;
}

[[noreturn]] void refuse(const Value& value, std::string_view key, const std::string& expected) {
  const std::string found = value.kind == Value::Kind::Scalar     ? fmt::format("'{}'", value.text.substr(0, 60))
                            : value.kind == Value::Kind::Sequence ? std::string("a list")
                                                                  : std::string("a map");
  throw InputError(value.where, fmt::format("max_error: {} must be {}, not {}", key, expected, found));
}

double readLength(const Value& value, std::string_view key) {
  const std::optional<Quantity> q = quantityOf(value);
  if (q && q->number >= 0) {
    if (q->unit == "mm") return q->number * 1e-3;
    if (q->unit == "cm") return q->number * 1e-2;
    if (q->unit == "m") return q->number;
  }
  if (q && q->number >= 0 && q->unit.empty()) {
    refuse(value, key, fmt::format("a length with its unit, such as {0:g} mm, {0:g} cm or {0:g} m", q->number));
  }
  refuse(value, key, "a length of at least 0 in mm, cm or m, such as 2 cm");
}

double readShare(const Value& value, std::string_view key, std::string_view example) {
  const std::optional<Quantity> q = quantityOf(value);
  if (q && (q->unit.empty() || q->unit == "%")) {
    const double share = q->unit.empty() ? q->number : q->number / 100;
    if (share >= 0 && share <= 1) return share;
    if (q->unit.empty() && share > 1 && share <= 100) {
      refuse(value, key, fmt::format("a share from 0 to 1 or in per cent, such as {:g} %", q->number));
    }
  }
  refuse(value, key, fmt::format("a share from 0 % to 100 %, such as {}", example));
}

// Reads a limit of an error.
double readLimit(const Limit& limit, const Value& value) {
  if (limit.kind == Kind::Length) return readLength(value, limit.key);
  if (limit.kind == Kind::Share) return readShare(value, limit.key, "0.1 % or 0.001");
  if (limit.kind == Kind::Agreement) return readShare(value, limit.key, "99.5 % or 0.995");
  return readNumber(value, fmt::format("max_error: {}", limit.key), {0, kInfinity});
}

}  // namespace

ErrorLimits readErrorLimits(const Value* errors, const Value* rateValue) {
  ErrorLimits limits;
  bool asked = false;
  if (errors != nullptr) {
    Fields fields(*errors, "max_error");
    for (const Limit& limit : kLimits) {
      if (limit.kind != Kind::Rate) fields.also({limit.key});
    }
    fields.finish();
    for (const Limit& limit : kLimits) {
      const Value* value = limit.kind == Kind::Rate ? nullptr : fields.find(limit.key);
      if (value == nullptr) continue;
      limits.*limit.allowed = readLimit(limit, *value);
      asked = true;
    }
  }
  if (rateValue != nullptr && rateValue->kind != Value::Kind::Null) {
    limits.minRate = readNumber(*rateValue, "min_rate (beams/s)", {1, kInfinity});
    asked = true;
  }
  if (asked) return limits;
  const Value* empty = errors != nullptr ? errors : rateValue;
  throw InputError(empty != nullptr ? empty->where : Location{},
                   "limits are missing: write limits such as `max_error: {p99: 2 cm, miss_rate: 0.1 %, labels: 99.5 "
                   "%}` or `min_rate: 5e6` (beams/s)");
}

std::vector<std::string> broken(const Candidate& candidate, const ErrorLimits& limits) {
  std::vector<std::string> texts;
  for (const Limit& limit : kLimits) {
    const auto& allowed = limits.*limit.allowed;
    if (!allowed) continue;
    const double value = limit.value(candidate);
    if (!holds(limit, value, *allowed)) texts.push_back(brokenText(limit, value, *allowed));
  }
  return texts;
}

std::vector<std::string> limitTexts(const Candidate& candidate, const ErrorLimits& limits) {
  std::vector<std::string> texts;
  for (const Limit& limit : kLimits) {
    const auto& allowed = limits.*limit.allowed;
    if (!allowed) continue;
    const Unit unit = unitOf(limit.kind, *allowed);
    const int digits = limit.kind == Kind::Agreement ? 6 : 3;  // six digits to show, for instance, 99.9989 %
    texts.push_back(fmt::format("{} {:.{}g}{}, {} {:.9g}{}", limit.key, limit.value(candidate) / unit.size, digits,
                                unit.name, limit.atLeast() ? "at least" : "at most", *allowed / unit.size, unit.name));
  }
  return texts;
}

bool moreExact(const GroupErrors& a, const GroupErrors& b) {
  const auto wrong = [](const GroupErrors& e) {
    const auto beams = static_cast<double>(std::max<std::uint64_t>(e.beams, 1));
    return static_cast<double>(e.falseNegatives + e.falsePositives + e.unresolved + e.bothHit - e.sameLabel) / beams;
  };
  if (wrong(a) != wrong(b)) return wrong(a) < wrong(b);
  return a.range.p99 != b.range.p99 ? a.range.p99 < b.range.p99 : a.range.mean < b.range.mean;
}

std::optional<std::size_t> bestThatHolds(std::span<const Candidate> candidates, const ErrorLimits& limits) {
  constexpr double kSameCost = 1.1;
  std::optional<std::size_t> best = cheapest(candidates, limits);
  if (!best) return best;
  const bool onlyRate = std::ranges::none_of(
      kLimits, [&](const Limit& limit) { return limit.kind != Kind::Rate && (limits.*limit.allowed).has_value(); });
  const double most = onlyRate ? kInfinity : kSameCost * candidates[*best].secondsPerBeam;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!(candidates[i].secondsPerBeam <= most) || !broken(candidates[i], limits).empty()) continue;
    if (moreExact(candidates[i].errors, candidates[*best].errors)) best = i;
  }
  return best;
}

std::optional<std::size_t> cheapest(std::span<const Candidate> candidates, const ErrorLimits& limits) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (std::isnan(candidates[i].secondsPerBeam) || !broken(candidates[i], limits).empty()) continue;
    if (!best || candidates[i].secondsPerBeam < candidates[*best].secondsPerBeam) best = i;
  }
  return best;
}

std::size_t nearestToHolding(std::span<const Candidate> candidates, const ErrorLimits& limits) {
  if (candidates.empty()) throw Error("there is no setting to choose from");
  // The cheaper of two candidates is returned if both exceed limits by the same factor.
  const auto order = [&](const Candidate& c) { return std::pair(largestExcess(c, limits), c.secondsPerBeam); };
  return static_cast<std::size_t>(std::ranges::min_element(candidates, {}, order) - candidates.begin());
}

std::vector<std::size_t> paretoFront(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size()) throw Error(fmt::format("{} and {} costs make no front", a.size(), b.size()));
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!std::isnan(a[i]) && !std::isnan(b[i])) order.push_back(i);
  }
  std::ranges::stable_sort(order,
                           [&](std::size_t l, std::size_t r) { return a[l] != a[r] ? a[l] < a[r] : b[l] < b[r]; });
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    const bool better = front.empty() || b[i] < b[front.back()];
    const bool equal = !front.empty() && a[i] == a[front.back()] && b[i] == b[front.back()];
    if (better || equal) front.push_back(i);
  }
  return front;
}

}  // namespace scanmill
