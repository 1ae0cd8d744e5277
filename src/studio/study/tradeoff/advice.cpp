#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "evaluate/limits.h"
#include "methods/method.h"
#include "study/figure_text.h"
#include "study/text_template.h"
#include "study/tradeoff/study.h"
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

// Relative difference below which times count as equal; repeated measurements differ by this much.
constexpr double kSameTime = 0.10;
constexpr double kSameShare = 1e-5;  // fraction of beams by which settings may differ and still count as equal
constexpr double kLittleGain = 1.5;  // speed-up factor below which accepting an error is seldom worthwhile
// Least ratio of the p99 of all beams to the p99 of beams away from edges at which the latter is reported too.
constexpr double kNotableEdges = 3;
constexpr std::size_t kMostNamed = 6;  // maximum number of settings in one sentence

struct Need {
  const char* name;
  const char* limits;  // the limits in words; empty: no limits
  std::optional<double> p95{}, p99{}, missRate{}, labels{};

  ErrorLimits asked() const { return {.p95 = p95, .p99 = p99, .missRate = missRate, .labels = labels}; }
};
const std::array<Need, 4> kNeeds{{
    {.name = "exact ranges and labels",
     .limits = "99 % of the ranges within 1 mm, 99.99 % of the labels and all but 0.01 % of the beams",
     .p99 = 1e-3,
     .missRate = 1e-4,
     .labels = 0.9999},
    {.name = "centimetres",
     .limits = "99 % of the ranges within 2 cm, 99.5 % of the labels and all but 0.2 % of the beams",
     .p99 = 0.02,
     .missRate = 2e-3,
     .labels = 0.995},
    {.name = "a decimetre for 95 % of the beams",
     .limits = "95 % of the ranges within 10 cm, 95 % of the labels and all but 1 % of the beams",
     .p95 = 0.1,
     .missRate = 0.01,
     .labels = 0.95},
    {.name = "speed at any price", .limits = ""},
}};

// A sentence that advice of the kind `kind` contains if `fact` is among the facts of the setting. Sentences are written
// in the order of kSentences.
struct Sentence {
  const char* kind;
  const char* fact;
  const char* text;
};
constexpr const char* kTake = "take";  // a setting that is recommended for a need
// A method that is not recommended, but has a setting that no other setting dominates.
constexpr const char* kUnbeaten = "unbeaten";
constexpr const char* kBeaten = "beaten";  // a method that is not recommended and all of whose settings are dominated
constexpr const char* kUnheld = "unheld";  // a need for which no setting is good enough
constexpr const char* kSlow = "slow";      // slow settings of methods that have another, recommended setting
constexpr const char* kAny = "any";        // sentences about any setting that may be recommended
constexpr auto kSentences = std::to_array<Sentence>({
    {kTake, "alone", "Only this setting was measured. "},
    {kTake, "no_trade_fastest",
     "It suits every need: of {{measured}} settings it is the fastest, none is more exact{{#limits}}, and it keeps "
     "{{limits}}{{/limits}}. "},
    {kTake, "no_trade",
     "It suits every need: of {{measured}} settings none is more exact{{#limits}}, and it keeps {{limits}}{{/limits}}, "
     "and none is notably faster. The fastest, {{fastest_name}}, is {{#gain:any}}{{gain:.0f}} "
     "%{{/gain:any}}{{^gain:any}}less than 1 %{{/gain:any}} faster, and times within 10 % count as equal. "},
    {kTake, "every_need",
     "It suits every need: of {{measured}} settings none is notably faster, and it keeps {{limits}}. "},
    {kTake, "fastest", "The fastest{{#limits}} that keeps {{limits}}{{/limits}}{{^limits}} of all{{/limits}}: "},
    {kTake, "as_fast",
     "About as fast as any{{#limits}} that keeps {{limits}}{{/limits}}{{^limits}} of all{{/limits}} (times within 10 % "
     "count as equal): "},
    {kUnbeaten, "name", "No need above selects it, but no setting is better than {{name}} in everything: "},
    {kAny, "name",
     "{{rate:amount}} beams a second{{#same_speed}}, about as fast as {{base}}{{/same_speed}}{{#faster}}, "
     "{{faster:factor}} x as fast as {{base}}{{/faster}}{{#slower}}, {{slower:factor}} x slower than "
     "{{base}}{{/slower}}. "},
    {kAny, "no_hits", "No beam hits the surface that it should hit"},
    {kAny, "exact", "99 % of the ranges are exact"},
    {kAny, "p99",
     "95 % of the ranges {{#p95}}lie within {{p95:m}}{{/p95}}{{^p95}}are exact{{/p95}}, 99 % within {{p99:m}}"},
    {kAny, "there_p99", " (there: {{there_p99}})"},
    {kAny, "name",
     ", {{labels:share}} of the labels agree{{#there_labels}} (there: {{there_labels:share}}){{/there_labels}}, "},
    {kAny, "name",
     "{{misses:share}} of the beams are false negatives or positives{{#there_misses}} (there: "
     "{{there_misses:share}}){{/there_misses}}."},
    {kAny, "away_exact", " Away from edges 99 % are exact."},
    {kAny, "away", " Away from edges 99 % lie within {{away:m}}."},
    {kAny, "name", " Set-up takes {{setup_s:s}}, memory {{memory:bytes}}."},
    {kAny, "gives_up_nothing", " It loses nothing that was measured."},
    {kAny, "little_gain", " It gains little speed for what it loses."},
    {kAny, "refused",
     " The pipeline cannot use {{method}}, since it has a footprint, light_paths or objects that move: leave these out "
     "(`footprint: none` beside `sensor`, `moving: false` beside the scene) to take it."},
    {kBeaten, "name",
     "{{name}} is {{#times}}{{times:factor}} x slower than{{/times}}{{^times}}no faster than{{/times}} {{better}}"
     "{{#losses:any}} and less exact ({{losses:join}}){{/losses:any}}{{^losses:any}} and no more exact{{/losses:any}}: "
     "no "
     "reason to take it here."},
    {kBeaten, "away_exact", " Away from edges 99 % are exact."},
    {kBeaten, "away", " Away from edges 99 % lie within {{away:m}}."},
    {kBeaten, "settings",
     " The same holds for each of its {{settings}} settings: another is as fast or faster, and as exact or more."},
    {kUnbeaten, "software", " OpenGL ran on the processor here; measure again where there is a graphics card."},
    {kBeaten, "software", " OpenGL ran on the processor here; measure again where there is a graphics card."},
    {kUnheld, "name", "No setting that was measured keeps {{limits}}. The nearest is {{name}}: {{breaks}}."},
    {kSlow, "slow",
     "Slower than another setting, and no more exact: {{#slow}}{{#next}}; {{/next}}{{name}} ({{times:factor}} x slower "
     "than {{better}}, {{#losses:any}}less{{/losses:any}}{{^losses:any}}no more{{/losses:any}} exact){{/slow}}"
     "{{#more:any}}; and {{more}} more{{/more:any}}."},
});
constexpr const char* kBase = "ray tracing with defaults";

std::string said(const char* kind, const char* other, const Json& facts) {
  std::string text;
  for (const Sentence& s : kSentences) {
    if ((s.kind == kind || s.kind == other) && facts.contains(s.fact)) text += fillTemplate(s.text, facts);
  }
  return text;
}

std::string p99Text(const GroupErrors& e) {
  const double p99 = rangeP99(e);
  return p99 == 0 ? "exact" : std::isnan(p99) ? "unknown" : metresText(p99);
}

// Compares settings to find the best ones. Settings are identified by their indices in Study::settings.
class Comparison {
 public:
  explicit Comparison(const Study& of)
      : study(of), measured(measuredSettings(of)), candidates(of.candidates()), base(tracingDefault(of)) {
    if (measured.empty()) return;
    fastest = fastestOf(measured);
    mostExact = mostExactOf(measured);
  }

  const SettingResult& result(std::size_t i) const { return study.settings[i]; }
  const std::string& nameOf(std::size_t i) const { return result(i).setting.name; }
  const GroupErrors& errors(std::size_t i) const { return result(i).measured.errors.all; }
  double seconds(std::size_t i) const { return result(i).measured.cost.scanSeconds; }
  double timesAsLong(std::size_t i, std::size_t other) const {
    return seconds(other) > 0 ? seconds(i) / seconds(other) : 1;
  }

  std::size_t fastestOf(const std::vector<std::size_t>& settings) const {
    return *std::ranges::min_element(settings, [&](std::size_t a, std::size_t b) { return seconds(a) < seconds(b); });
  }
  // True if setting `i` is faster than `other` by more than kSameTime.
  bool notablyFaster(std::size_t i, std::size_t other) const { return seconds(i) * (1 + kSameTime) < seconds(other); }

  bool rangesWorse(std::size_t i, std::size_t other) const {
    const double mine = rangeP99(errors(i)), its = rangeP99(errors(other));
    return mine > its + kExactRange || std::isnan(mine) > std::isnan(its);
  }
  bool labelsWorse(std::size_t i, std::size_t other) const {
    return errors(i).labels() < errors(other).labels() - kSameShare;
  }
  bool missesWorse(std::size_t i, std::size_t other) const {
    return errors(i).missRate() > errors(other).missRate() + kSameShare;
  }
  bool worse(std::size_t i, std::size_t other) const {
    return rangesWorse(i, other) || labelsWorse(i, other) || missesWorse(i, other);
  }
  // True if setting `i` is not notably slower than `other`, and not less exact in ranges, labels or misses.
  bool beats(std::size_t i, std::size_t other) const { return !notablyFaster(other, i) && !worse(i, other); }

  // Returns the fastest setting that dominates `i`: it beats `i`, and is notably faster or in one respect more exact.
  // Returns nothing if no setting dominates `i`.
  std::optional<std::size_t> dominator(std::size_t i) const {
    std::optional<std::size_t> best;
    for (const std::size_t other : measured) {
      if (other == i || !beats(other, i) || (!notablyFaster(other, i) && !worse(i, other))) continue;
      if (!best || seconds(other) < seconds(*best)) best = other;
    }
    return best;
  }

  // Among the settings that are about as fast as the fastest, returns one with default options if possible, otherwise
  // the most exact.
  std::size_t plainest(const std::vector<std::size_t>& settings) const {
    const std::size_t first = fastestOf(settings);
    std::size_t best = first;
    for (const std::size_t i : settings) {
      if (notablyFaster(first, i)) continue;
      const bool mine = isDefault(result(i).setting), its = isDefault(result(best).setting);
      if (mine != its ? mine : moreExact(errors(i), errors(best))) best = i;
    }
    // Prefer a setting with defaults to a setting that is neither faster nor more exact.
    for (const std::size_t i : settings) {
      if (!isDefault(result(best).setting) && isDefault(result(i).setting) && beats(i, best)) best = i;
    }
    return best;
  }

  // Returns the plainest() of the settings with the fewest wrong beams and, among these, the smallest range error.
  // Differences up to kSameShare (wrong beams) and kExactRange (range error) do not count.
  std::size_t mostExactOf(const std::vector<std::size_t>& settings) const {
    double least = 1;
    for (const std::size_t i : settings) least = std::min(least, wrongShare(errors(i)));
    std::vector<std::size_t> few, exact;
    for (const std::size_t i : settings) {
      if (wrongShare(errors(i)) <= least + kSameShare) few.push_back(i);
    }
    for (const std::size_t i : few) {
      if (std::ranges::none_of(few, [&](std::size_t other) { return rangesWorse(i, other); })) {
        exact.push_back(i);
      }
    }
    return plainest(exact.empty() ? few : exact);
  }

  const Study& study;
  std::vector<std::size_t> measured;
  std::vector<Candidate> candidates;
  std::optional<std::size_t> base;
  std::size_t fastest = 0, mostExact = 0;
};

// Returns the facts that the sentences about a setting need. Facts named `there_...` are values of ray tracing with
// defaults; they are given only where these values are better.
Json factsOf(const Comparison& c, std::size_t i) {
  const GroupErrors& e = c.errors(i);
  const Cost& cost = c.result(i).measured.cost;
  const std::string& method = c.result(i).setting.method;
  Json facts{
      {"name", c.nameOf(i)},           {"method", method},           {"base", kBase},
      {"measured", c.measured.size()}, {"labels", e.labels()},       {"misses", e.missRate()},
      {"setup_s", cost.setupSeconds},  {"memory", cost.memoryBytes}, {"rate", beamsPerSecond(c.study, c.result(i))}};
  const double p99 = rangeP99(e);
  if (std::isnan(p99)) {
    facts["no_hits"] = true;
  } else if (p99 == 0) {
    facts["exact"] = true;
  } else {
    facts["p99"] = p99;
    facts["p95"] = e.range.p95 < kExactRange ? Json() : Json(e.range.p95);
  }
  // The p99 of most shortcuts is determined by beams near silhouettes, so report also the p99 of the other beams.
  const GroupErrors* group = awayFromEdges(c.result(i).measured.errors);
  if (group != nullptr && group->range.count > 0 && p99 > kNotableEdges * rangeP99(*group)) {
    facts[rangeP99(*group) == 0 ? "away_exact" : "away"] = rangeP99(*group);
  }
  const MethodEntry* entry = findMethod(method);
  for (const char* renderer : {"llvmpipe", "softpipe"}) {
    const bool software = c.study.machine.renderer.find(renderer) != std::string::npos;
    if (software && entry != nullptr && entry->can.passes) facts["software"] = true;
  }
  const std::vector<std::string>& refused = c.study.refused;
  if (std::ranges::find(refused, method) != refused.end()) facts["refused"] = true;
  if (!c.base || *c.base == i) return facts;
  const GroupErrors& there = c.errors(*c.base);
  if (c.rangesWorse(i, *c.base)) facts["there_p99"] = p99Text(there);
  if (c.labelsWorse(i, *c.base)) facts["there_labels"] = there.labels();
  if (c.missesWorse(i, *c.base)) facts["there_misses"] = there.missRate();
  if (c.seconds(i) <= 0 || c.seconds(*c.base) <= 0) return facts;
  const double faster = c.seconds(*c.base) / c.seconds(i);
  facts[std::abs(faster - 1) <= kSameTime ? "same_speed"
        : faster > 1                      ? "faster"
                                          : "slower"] = faster > 1 ? faster : 1 / faster;
  if (!c.worse(i, *c.base)) {
    facts["gives_up_nothing"] = true;
  } else if (faster > 1 && faster < kLittleGain) {
    facts["little_gain"] = true;
  }
  return facts;
}

// Returns facts that state in which respects setting `i` is worse than `better`, and how much slower.
Json beatenFacts(const Comparison& c, std::size_t i, std::size_t better) {
  const GroupErrors &a = c.errors(i), &b = c.errors(better);
  const Json values{{"p99", p99Text(a)},        {"its_p99", p99Text(b)},  {"labels", a.labels()},
                    {"its_labels", b.labels()}, {"misses", a.missRate()}, {"its_misses", b.missRate()}};
  Json facts{{"name", c.nameOf(i)}, {"better", c.nameOf(better)}, {"losses", Json::array()}};
  const auto add = [&](bool loses, const char* text) {
    if (loses) facts["losses"].push_back(fillTemplate(text, values));
  };
  add(c.rangesWorse(i, better), "p99 of the ranges {{p99}} against {{its_p99}}");
  add(c.labelsWorse(i, better), "{{labels:share}} of the labels against {{its_labels:share}}");
  add(c.missesWorse(i, better), "{{misses:share}} false negatives or positives against {{its_misses:share}}");
  if (c.notablyFaster(better, i)) facts["times"] = c.timesAsLong(i, better);
  return facts;
}

struct Answer {
  std::size_t setting;
  std::vector<const Need*> needs;
  bool fastest;  // true: the fastest of the settings that keep the limits
};

// Returns a heading such as "For exact ranges and labels, for centimetres, and for speed at any price".
std::string heading(const Answer& answer) {
  if (answer.needs.size() == kNeeds.size()) return "For every need";
  std::string text;
  for (std::size_t i = 0; i < answer.needs.size(); ++i) {
    text += (i == 0                        ? "For "
             : i + 1 < answer.needs.size() ? ", for "
                                           : ", and for ") +
            std::string(answer.needs[i]->name);
  }
  return text;
}

Advice adviceTo(const Comparison& c, const Answer& answer, bool noTrade) {
  Json facts = factsOf(c, answer.setting);
  facts["limits"] = answer.needs.front()->limits;
  const bool every = answer.needs.size() == kNeeds.size();
  if (!noTrade || answer.setting != c.mostExact) {
    facts[every ? "every_need" : answer.fastest ? "fastest" : "as_fast"] = true;
  } else if (c.measured.size() == 1) {
    facts["alone"] = true;
  } else if (c.fastest == answer.setting) {
    facts["no_trade_fastest"] = true;
  } else {
    const double gain = 100 * (c.timesAsLong(answer.setting, c.fastest) - 1);
    facts.update({{"no_trade", true}, {"fastest_name", c.nameOf(c.fastest)}, {"gain", gain < 1 ? 0 : gain}});
  }
  return {heading(answer), c.nameOf(answer.setting), said(kTake, kAny, facts)};
}

// Returns advice about a method that is recommended for no need: whether there is a reason to use it at all. `own`: the
// method's settings.
Advice judge(const Comparison& c, const std::string& method, const std::vector<std::size_t>& own) {
  const std::string need = "Whether to take " + method;
  std::vector<std::size_t> unbeaten;
  std::ranges::copy_if(own, std::back_inserter(unbeaten), [&](std::size_t i) { return !c.dominator(i); });
  if (!unbeaten.empty()) {
    const std::size_t best = c.fastestOf(unbeaten);
    return {need, c.nameOf(best), said(kUnbeaten, kAny, factsOf(c, best))};
  }
  const auto byDefault = std::ranges::find_if(own, [&](std::size_t i) { return isDefault(c.result(i).setting); });
  const std::size_t shown = byDefault != own.end() ? *byDefault : c.fastestOf(own);
  const bool byBase = c.base && c.beats(*c.base, shown) && (c.notablyFaster(*c.base, shown) || c.worse(shown, *c.base));
  const std::size_t better = byBase ? *c.base : *c.dominator(shown);
  Json facts = factsOf(c, shown);
  facts.update(beatenFacts(c, shown, better));
  if (c.base && better == *c.base) facts["better"] = kBase;
  if (facts["losses"].empty()) facts.erase("away"), facts.erase("away_exact");
  if (own.size() > 1) facts["settings"] = own.size();
  return {need, "", said(kBeaten, kBeaten, facts)};
}

}  // namespace

std::vector<Advice> advise(const Study& study) {
  const Comparison c(study);
  if (c.measured.empty()) return {};
  // If the most exact setting is as fast as the fastest, accepting errors gains nothing.
  const bool noTrade = !c.notablyFaster(c.fastest, c.mostExact);
  std::vector<Answer> answers;
  std::vector<Advice> advice, unheld;
  for (const Need& need : kNeeds) {
    std::vector<std::size_t> holding;
    for (std::size_t k = 0; k < c.candidates.size(); ++k) {
      if (broken(c.candidates[k], need.asked()).empty()) holding.push_back(c.measured[k]);
    }
    if (holding.empty()) {
      const std::size_t nearest = nearestToHolding(c.candidates, need.asked());
      std::string breaks;
      for (const std::string& limit : broken(c.candidates[nearest], need.asked())) {
        breaks += (breaks.empty() ? "" : "; ") + limit;
      }
      unheld.push_back({std::string("For ") + need.name, "",
                        said(kUnheld, kUnheld,
                             {{"limits", need.limits}, {"name", c.nameOf(c.measured[nearest])}, {"breaks", breaks}})});
      continue;
    }
    const bool exactHolds = std::ranges::find(holding, c.mostExact) != holding.end();
    const std::size_t setting = noTrade && exactHolds ? c.mostExact : c.plainest(holding);
    const auto same = std::ranges::find_if(answers, [&](const Answer& a) { return a.setting == setting; });
    if (same != answers.end()) {
      same->needs.push_back(&need);
    } else {
      answers.push_back({setting, {&need}, c.seconds(setting) <= c.seconds(c.fastestOf(holding))});
    }
  }
  for (const Answer& answer : answers) advice.push_back(adviceTo(c, answer, noTrade));
  advice.insert(advice.end(), unheld.begin(), unheld.end());

  // List the slow settings of methods that have another, recommended setting. A setting that is as fast as the one it
  // is compared with is not listed, since it might be faster in another run.
  Json slow = Json::array();
  for (const std::string& method : methodsOf(study)) {
    const auto ofMethod = [&](std::size_t i) { return c.result(i).setting.method == method; };
    std::vector<std::size_t> own;
    std::ranges::copy_if(c.measured, std::back_inserter(own), ofMethod);
    const bool answering = std::ranges::any_of(answers, [&](const Answer& a) { return ofMethod(a.setting); });
    if (!own.empty() && !answering) advice.push_back(judge(c, method, own));
    for (const std::size_t i : own) {
      const std::optional<std::size_t> by = c.dominator(i);
      const bool taken = std::ranges::any_of(answers, [&](const Answer& a) { return a.setting == i; });
      if (!answering || taken || !by || !c.notablyFaster(*by, i)) continue;
      slow.push_back(beatenFacts(c, i, *by));
      slow.back()["next"] = slow.size() > 1;
    }
  }
  if (!slow.empty()) {
    const std::size_t more = slow.size() - std::min(slow.size(), kMostNamed);
    slow.erase(slow.begin() + static_cast<std::ptrdiff_t>(slow.size() - more), slow.end());
    advice.push_back({"What not to take", "", said(kSlow, kSlow, {{"slow", slow}, {"more", more}})});
  }
  return advice;
}

}  // namespace scanmill
