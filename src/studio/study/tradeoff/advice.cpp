#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/short_text.h"
#include "evaluate/limits.h"
#include "methods/method.h"
#include "study/figure_text.h"
#include "study/tradeoff/study.h"
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

constexpr double kSameTime = 0.10;     // of times: two measurements of the same work differ by as much
constexpr double kSameShare = 1e-5;    // of beams: one in a hundred thousand decides nothing
constexpr double kLittleGain = 1.5;    // times as fast: less is seldom worth an error
constexpr std::size_t kMostNamed = 6;  // settings in one sentence

struct Need {
  std::string name;
  std::string limits;   // in words
  std::string holding;  // after "the fastest" and "about as fast as any"
  ErrorLimits asked;
};

std::vector<Need> needs() {
  std::vector<Need> list(4);
  list[0].name = "exact ranges and labels";
  list[0].limits = "99 % of the ranges within 1 mm, 99.99 % of the labels and all but 0.01 % of the beams";
  list[0].asked.p99 = 1e-3;
  list[0].asked.labels = 0.9999;
  list[0].asked.missRate = 1e-4;
  list[1].name = "centimetres";
  list[1].limits = "99 % of the ranges within 2 cm, 99.5 % of the labels and all but 0.2 % of the beams";
  list[1].asked.p99 = 0.02;
  list[1].asked.labels = 0.995;
  list[1].asked.missRate = 2e-3;
  list[2].name = "a decimetre for 95 % of the beams";
  list[2].limits = "95 % of the ranges within 10 cm, 95 % of the labels and all but 1 % of the beams";
  list[2].asked.p95 = 0.1;
  list[2].asked.labels = 0.95;
  list[2].asked.missRate = 0.01;
  list[3].name = "speed at any price";
  list[3].limits = "no limit at all";
  for (Need& need : list) need.holding = " that keeps " + need.limits;
  list[3].holding = " of all";
  return list;
}

bool rangesWorse(const GroupErrors& a, const GroupErrors& b) {
  const double mine = rangeP99(a), its = rangeP99(b);
  return mine > its + kExactRange || std::isnan(mine) > std::isnan(its);
}
bool labelsWorse(const GroupErrors& a, const GroupErrors& b) {
  return a.labels() < b.labels() - kSameShare;
}
bool missesWorse(const GroupErrors& a, const GroupErrors& b) {
  return a.missRate() > b.missRate() + kSameShare;
}

std::string p99Text(const GroupErrors& e) {
  const double p99 = rangeP99(e);
  return p99 == 0 ? "exact" : std::isnan(p99) ? "unknown" : metresText(p99);
}

std::string capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

// "For exact ranges and labels, for centimetres, and for speed at any price".
std::string forNeeds(const std::vector<Need>& asked) {
  std::string text;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    text += (i == 0 ? "For " : i + 1 < asked.size() ? ", for " : ", and for ") + asked[i].name;
  }
  return text;
}

class Adviser {
 public:
  explicit Adviser(const Study& study)
      : study_(study),
        measured_(measuredSettings(study)),
        candidates_(study.candidates()),
        base_(tracingDefault(study)) {
    if (measured_.empty()) return;
    fastest_ = fastestOf(measured_);
    mostExact_ = mostExact();
  }

  std::vector<Advice> advise() {
    if (measured_.empty()) return {};
    answerNeeds();
    judgeMethods();
    nameDominated();
    return std::move(advice_);
  }

 private:
  const SettingResult& result(std::size_t i) const { return study_.settings[i]; }
  const std::string& nameOf(std::size_t i) const { return result(i).setting.name; }
  const GroupErrors& errors(std::size_t i) const { return result(i).measured.errors.all; }
  double seconds(std::size_t i) const { return result(i).measured.cost.scanSeconds; }

  std::size_t fastestOf(const std::vector<std::size_t>& settings) const {
    return *std::min_element(settings.begin(), settings.end(),
                             [&](std::size_t a, std::size_t b) { return seconds(a) < seconds(b); });
  }
  // Times that differ by less are equal.
  bool notablyFaster(std::size_t i, std::size_t other) const { return seconds(i) * (1 + kSameTime) < seconds(other); }

  std::string baseName() const { return "ray tracing with defaults"; }

  // "2.1 x slower than ray tracing with defaults"; empty where that was not measured, or is this.
  std::string comparedSpeed(std::size_t i) const {
    if (!base_ || *base_ == i || seconds(i) <= 0 || seconds(*base_) <= 0) return "";
    const double faster = seconds(*base_) / seconds(i);
    if (std::abs(faster - 1) <= kSameTime) return fmt::format("about as fast as {}", baseName());
    return faster > 1 ? fmt::format("{} x as fast as {}", factorText(faster), baseName())
                      : fmt::format("{} x slower than {}", factorText(1 / faster), baseName());
  }

  // With what ray tracing with defaults has in brackets, where that is better.
  std::string accuracy(std::size_t i) const {
    const GroupErrors& e = errors(i);
    const GroupErrors* there = base_ && *base_ != i ? &errors(*base_) : nullptr;
    const auto better = [&](bool worse, const std::string& text) {
      return worse ? fmt::format(" (there: {})", text) : std::string();
    };
    const double p99 = rangeP99(e);
    const std::string ranges =
        std::isnan(p99) ? "no beam hits what it should"
        : p99 == 0      ? std::string("99 % of the ranges are exact")
                        : fmt::format("95 % of the ranges {}, 99 % within {}",
                                 e.range.p95 < kExactRange ? "are exact" : "lie within " + metresText(e.range.p95),
                                      metresText(p99));
    return fmt::format(
        "{}{}, {} of the labels agree{}, {} of the beams are false negatives or positives{}", ranges,
        better(there != nullptr && rangesWorse(e, *there), there == nullptr ? "" : p99Text(*there)),
        shareText(e.labels()),
        better(there != nullptr && labelsWorse(e, *there), there == nullptr ? "" : shareText(there->labels())),
        shareText(e.missRate()),
        better(there != nullptr && missesWorse(e, *there), there == nullptr ? "" : shareText(there->missRate())));
  }

  // Silhouettes decide the p99 of most shortcuts: what is there away from them?
  std::string awayText(std::size_t i) const {
    constexpr double kNotable = 3;
    const GroupErrors* group = awayFromEdges(result(i).measured.errors);
    if (group == nullptr || group->range.count == 0) return "";
    const double away = rangeP99(*group);
    if (!(rangeP99(errors(i)) > kNotable * away)) return "";
    return away == 0 ? " Away from edges 99 % are exact."
                     : fmt::format(" Away from edges 99 % lie within {}.", metresText(away));
  }

  std::string described(std::size_t i) const {
    const std::string speed = comparedSpeed(i);
    const Cost& cost = result(i).measured.cost;
    return fmt::format("{} beams a second{}. {}.{} Set-up takes {}, memory {}.{}",
                       amountText(beamsPerSecond(study_, result(i))), speed.empty() ? "" : ", " + speed,
                       capitalised(accuracy(i)), awayText(i), secondsText(cost.setupSeconds),
                       shortBytes(static_cast<double>(cost.memoryBytes)), judged(i) + refusedText(i));
  }

  std::string refusedText(std::size_t i) const {
    const std::string& method = result(i).setting.method;
    if (std::find(study_.refused.begin(), study_.refused.end(), method) == study_.refused.end()) return "";
    return fmt::format(
        " The pipeline refuses {} as it is, for it has a footprint, light_paths or objects that move: leave them out "
        "(`footprint: none` beside `sensor`, `moving: false` beside the scene) to take it.",
        method);
  }

  // In what `i` is worse than `other`: "ranges (p99 46 mm against 0)".
  std::vector<std::string> worse(std::size_t i, std::size_t other) const {
    const GroupErrors &a = errors(i), &b = errors(other);
    std::vector<std::string> list;
    if (rangesWorse(a, b)) list.push_back(fmt::format("p99 of the ranges {} against {}", p99Text(a), p99Text(b)));
    if (labelsWorse(a, b)) {
      list.push_back(fmt::format("{} of the labels against {}", shareText(a.labels()), shareText(b.labels())));
    }
    if (missesWorse(a, b)) {
      list.push_back(
          fmt::format("{} false negatives or positives against {}", shareText(a.missRate()), shareText(b.missRate())));
    }
    return list;
  }

  // Another that is as fast or faster and worse in nothing, and better in something: the fastest such.
  std::optional<std::size_t> dominator(std::size_t i) const {
    std::optional<std::size_t> best;
    for (const std::size_t other : measured_) {
      if (other == i || !beats(other, i)) continue;
      if (!notablyFaster(other, i) && worse(i, other).empty()) continue;
      if (!best || seconds(other) < seconds(*best)) best = other;
    }
    return best;
  }

  // Is it worth what it gives up?
  std::string judged(std::size_t i) const {
    if (!base_ || *base_ == i || seconds(i) <= 0) return "";
    if (worse(i, *base_).empty()) return " It gives up nothing that was measured.";
    const double faster = seconds(*base_) / seconds(i);
    return faster > 1 && faster < kLittleGain ? " That is little speed for what it gives up." : "";
  }

  // Of settings that are as fast as the fastest of them: defaults if they are among them, then the most exact.
  std::size_t plainest(const std::vector<std::size_t>& settings) const {
    const std::size_t fastest = fastestOf(settings);
    std::size_t best = fastest;
    for (const std::size_t i : settings) {
      if (notablyFaster(fastest, i)) continue;
      const bool mine = isDefault(result(i).setting), its = isDefault(result(best).setting);
      if (mine != its ? mine : moreExact(errors(i), errors(best))) best = i;
    }
    // What is as fast and as exact as defaults is no reason to set anything.
    for (const std::size_t i : settings) {
      if (!isDefault(result(best).setting) && isDefault(result(i).setting) && beats(i, best)) best = i;
    }
    return best;
  }

  // Of those that err least, as far as that decides anything, the plainest.
  std::size_t mostExact() const {
    double least = wrongShare(errors(measured_.front()));
    for (const std::size_t i : measured_) least = std::min(least, wrongShare(errors(i)));
    std::vector<std::size_t> few, exact;
    for (const std::size_t i : measured_) {
      if (wrongShare(errors(i)) <= least + kSameShare) few.push_back(i);
    }
    for (const std::size_t i : few) {
      const bool beaten =
          std::any_of(few.begin(), few.end(), [&](std::size_t other) { return rangesWorse(errors(i), errors(other)); });
      if (!beaten) exact.push_back(i);
    }
    return plainest(exact.empty() ? few : exact);
  }

  struct Answer {
    std::size_t setting;
    std::vector<Need> needs;
    bool fastest;  // of those that hold
  };

  void answerNeeds() {
    // Where the most exact setting is as fast as any, nothing is to be had for an error.
    const bool noTrade = !notablyFaster(fastest_, mostExact_);
    std::vector<Answer> answers;
    std::vector<Advice> unheld;
    std::size_t asked = 0;
    for (Need& need : needs()) {
      ++asked;
      std::vector<std::size_t> holding;
      for (std::size_t c = 0; c < candidates_.size(); ++c) {
        if (broken(candidates_[c], need.asked).empty()) holding.push_back(measured_[c]);
      }
      if (holding.empty()) {
        const std::size_t nearest = nearestToHolding(candidates_, need.asked);
        unheld.push_back(
            {"For " + need.name, "",
             fmt::format("No setting that was measured keeps {}. The nearest is {}: {}.", need.limits,
                         nameOf(measured_[nearest]), fmt::join(broken(candidates_[nearest], need.asked), "; "))});
        continue;
      }
      const bool exactHolds = std::find(holding.begin(), holding.end(), mostExact_) != holding.end();
      const std::size_t setting = noTrade && exactHolds ? mostExact_ : plainest(holding);
      const auto same =
          std::find_if(answers.begin(), answers.end(), [&](const Answer& a) { return a.setting == setting; });
      if (same != answers.end()) {
        same->needs.push_back(std::move(need));
      } else {
        answers.push_back({setting, {std::move(need)}, seconds(setting) <= seconds(fastestOf(holding))});
      }
    }
    for (const Answer& answer : answers) {
      winners_.push_back(answer.setting);
      const std::string lead = noTrade && answer.setting == mostExact_
                                   ? noTradeText(answer)
                                   : fastestText(answer, answer.needs.size() == asked);
      advice_.push_back({answer.needs.size() == asked ? "For every need" : forNeeds(answer.needs),
                         nameOf(answer.setting), lead + described(answer.setting)});
    }
    advice_.insert(advice_.end(), unheld.begin(), unheld.end());
  }

  std::string fastestText(const Answer& answer, bool everyNeed) const {
    if (everyNeed) {
      return fmt::format("Take it whatever you need: of {} settings none is notably faster, and it keeps {}. ",
                         measured_.size(), answer.needs.front().limits);
    }
    const std::string within = fmt::format("About as fast as any{} (times within {:.0f} % count as equal)",
                                           answer.needs.front().holding, 100 * kSameTime);
    return (answer.fastest ? "The fastest" + answer.needs.front().holding : within) + ": ";
  }

  std::string noTradeText(const Answer& answer) const {
    if (measured_.size() == 1) return "Only this setting was measured. ";
    const std::string limits =
        answer.needs.front().asked.labels ? fmt::format(", and it keeps {}", answer.needs.front().limits) : "";
    if (fastest_ == answer.setting) {
      return fmt::format("Take it whatever you need: of {} settings it is the fastest, none is more exact{}. ",
                         measured_.size(), limits);
    }
    const double faster = seconds(fastest_) > 0 ? seconds(answer.setting) / seconds(fastest_) - 1 : 0;
    return fmt::format(
        "Take it whatever you need: of {} settings none is more exact{}, and none is notably faster. The fastest, {}, "
        "is {} faster, and times within {:.0f} % count as equal. ",
        measured_.size(), limits, nameOf(fastest_),
        faster < 0.01 ? std::string("less than 1 %") : fmt::format("{:.0f} %", 100 * faster), 100 * kSameTime);
  }

  // Of a method that answers no need: is there a reason to take it at all?
  void judgeMethods() {
    for (const std::string& method : methodsOf(study_)) {
      const auto ofMethod = [&](std::size_t i) { return result(i).setting.method == method; };
      std::vector<std::size_t> own, undominated;
      std::copy_if(measured_.begin(), measured_.end(), std::back_inserter(own), ofMethod);
      if (own.empty() || std::any_of(winners_.begin(), winners_.end(), ofMethod)) continue;
      std::copy_if(own.begin(), own.end(), std::back_inserter(undominated),
                   [&](std::size_t i) { return !dominator(i); });
      judged_.push_back(method);
      const std::string need = fmt::format("Whether to take {}", method);
      if (!undominated.empty()) {
        const std::size_t best = fastestOf(undominated);
        advice_.push_back({need, nameOf(best),
                           fmt::format("It answers none of the needs above, but nothing beats {} in everything: {}{}",
                                       nameOf(best), described(best), graphicsRemark(method))});
        continue;
      }
      const auto byDefault =
          std::find_if(own.begin(), own.end(), [&](std::size_t i) { return isDefault(result(i).setting); });
      const std::size_t shown = byDefault != own.end() ? *byDefault : fastestOf(own);
      const bool byBase =
          base_ && beats(*base_, shown) && (notablyFaster(*base_, shown) || !worse(shown, *base_).empty());
      const std::size_t better = byBase ? *base_ : *dominator(shown);
      const std::vector<std::string> losses = worse(shown, better);
      const double slower = seconds(better) > 0 ? seconds(shown) / seconds(better) : 1;
      advice_.push_back(
          {need, "",
           fmt::format(
               "{} {} {}{}: no reason to take it here.{}{}{}", nameOf(shown),
               notablyFaster(better, shown) ? fmt::format("is {} x slower than", factorText(slower))
                                            : "is no faster than",
               base_ && better == *base_ ? baseName() : nameOf(better),
               losses.empty() ? " and no more exact" : fmt::format(" and less exact ({})", fmt::join(losses, ", ")),
               losses.empty() ? "" : awayText(shown),
               own.size() == 1 ? ""
                               : fmt::format(" The same holds for each of its {} settings: another is as fast "
                                             "or faster, and as exact or more.",
                                             own.size()),
               graphicsRemark(method))});
    }
  }

  // As fast or faster, and worse in nothing.
  bool beats(std::size_t i, std::size_t other) const { return !notablyFaster(other, i) && worse(i, other).empty(); }

  // The figures of a method that draws say little where no graphics card drew.
  std::string graphicsRemark(const std::string& method) const {
    const bool software = study_.machine.renderer.find("llvmpipe") != std::string::npos ||
                          study_.machine.renderer.find("softpipe") != std::string::npos;
    const MethodEntry* entry = findMethod(method);
    if (entry == nullptr || !entry->can.passes || !software) return "";
    return " OpenGL ran on the processor here; measure again where there is a graphics card.";
  }

  // Of the methods that do answer a need: the settings that nobody needs. What is as fast as its better is not named:
  // it might be as good on another day.
  void nameDominated() {
    std::vector<std::string> named;
    std::size_t count = 0;
    for (const std::size_t i : measured_) {
      if (std::find(judged_.begin(), judged_.end(), result(i).setting.method) != judged_.end()) continue;
      const std::optional<std::size_t> by = dominator(i);
      if (!by || !notablyFaster(*by, i) || std::find(winners_.begin(), winners_.end(), i) != winners_.end()) continue;
      ++count;
      if (named.size() == kMostNamed) continue;
      const double slower = seconds(*by) > 0 ? seconds(i) / seconds(*by) : 1;
      named.push_back(fmt::format("{} ({} x slower than {}, {})", nameOf(i), factorText(slower), nameOf(*by),
                                  worse(i, *by).empty() ? "no more exact" : "less exact"));
    }
    if (named.empty()) return;
    if (count > named.size()) named.push_back(fmt::format("and {} more", count - named.size()));
    advice_.push_back({"What not to take", "",
                       fmt::format("Slower than another setting, and no more exact: {}.", fmt::join(named, "; "))});
  }

  const Study& study_;
  std::vector<std::size_t> measured_;
  std::vector<Candidate> candidates_;
  std::optional<std::size_t> base_;
  std::size_t fastest_ = 0, mostExact_ = 0;
  std::vector<std::size_t> winners_;
  std::vector<std::string> judged_;  // methods
  std::vector<Advice> advice_;
};

}  // namespace

std::vector<Advice> advise(const Study& study) {
  return Adviser(study).advise();
}

}  // namespace scanmill
