#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "evaluate/limits.h"
#include "pipeline/progress.h"
#include "study/report_figures.h"
#include "study/study.h"

namespace scanmill {

namespace {

constexpr double kSameTime = 0.05;     // of times: two measurements of the same work differ by as much
constexpr double kSameShare = 1e-5;    // of beams: one in a hundred thousand decides nothing
constexpr double kLittleGain = 1.5;    // times as fast: less is seldom worth an error
constexpr std::size_t kMostNamed = 6;  // settings in one sentence

struct Need {
  std::string name;
  std::string limits;   // in words
  std::string holding;  // after "the fastest"
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
  list[2].name = "a decimetre and most labels";
  list[2].limits = "95 % of the ranges within 10 cm, 95 % of the labels and all but 1 % of the beams";
  list[2].asked.p95 = 0.1;
  list[2].asked.labels = 0.95;
  list[2].asked.missRate = 0.01;
  list[3].name = "the fastest at any price";
  list[3].limits = "no limit at all";
  for (Need& need : list) need.holding = "that keeps " + need.limits;
  list[3].holding = "of all";
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

class Adviser {
 public:
  explicit Adviser(const Study& study)
      : study_(study),
        measured_(measuredSettings(study)),
        candidates_(study.candidates()),
        base_(tracingDefault(study)) {}

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
        "{}{}, {} of the labels agree{}, {} of the beams are lost or invented{}", ranges,
        better(there != nullptr && rangesWorse(e, *there), there == nullptr ? "" : p99Text(*there)),
        shareText(e.labels()),
        better(there != nullptr && labelsWorse(e, *there), there == nullptr ? "" : shareText(there->labels())),
        shareText(e.missRate()),
        better(there != nullptr && missesWorse(e, *there), there == nullptr ? "" : shareText(there->missRate())));
  }

  // Silhouettes decide the p99 of most shortcuts: what is there away from them?
  std::string awayFromEdges(std::size_t i) const {
    constexpr double kNotable = 3;
    for (const ErrorGroup& group : result(i).measured.errors.byPlace) {
      if (group.name != "interior" || group.errors.range.count == 0) continue;
      const double inside = rangeP99(group.errors);
      if (!(rangeP99(errors(i)) > kNotable * inside)) return "";
      return inside == 0 ? " Away from edges 99 % are exact."
                         : fmt::format(" Away from edges 99 % lie within {}.", metresText(inside));
    }
    return "";
  }

  std::string described(std::size_t i) const {
    const std::string speed = comparedSpeed(i);
    const Cost& cost = result(i).measured.cost;
    return fmt::format("{} beams a second{}. {}.{} Set-up takes {}, memory {}.{}",
                       amountText(beamsPerSecond(study_, result(i))), speed.empty() ? "" : ", " + speed,
                       capitalised(accuracy(i)), awayFromEdges(i), secondsText(cost.setupSeconds),
                       shortBytes(static_cast<double>(cost.memoryBytes)), judged(i));
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
          fmt::format("{} of the beams lost or invented against {}", shareText(a.missRate()), shareText(b.missRate())));
    }
    return list;
  }

  // Another that is as fast or faster and worse in nothing, and better in something: the fastest such. Time within its
  // noise is no merit.
  std::optional<std::size_t> dominator(std::size_t i) const {
    std::optional<std::size_t> best;
    for (const std::size_t other : measured_) {
      if (other == i || seconds(other) > seconds(i) || !worse(other, i).empty()) continue;
      if (seconds(other) * (1 + kSameTime) >= seconds(i) && worse(i, other).empty()) continue;
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

  // Of the settings that hold and are as fast within the noise of time: defaults if they are among them, else the
  // first.
  std::size_t plainest(std::size_t fastest, const ErrorLimits& asked) const {
    std::optional<std::size_t> first;
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      const bool equal = candidates_[c].secondsPerBeam <= candidates_[fastest].secondsPerBeam * (1 + kSameTime);
      if (!equal || !broken(candidates_[c], asked).empty()) continue;
      if (isDefault(result(measured_[c]).setting)) return measured_[c];
      if (!first) first = measured_[c];
    }
    return first.value_or(measured_[fastest]);
  }

  void answerNeeds() {
    struct Answer {
      std::size_t setting;
      std::vector<Need> needs;
    };
    std::vector<Answer> answers;
    std::vector<Advice> unheld;
    for (Need& need : needs()) {
      const std::optional<std::size_t> found = cheapest(candidates_, need.asked);
      if (!found) {
        const std::size_t nearest = nearestToHolding(candidates_, need.asked);
        unheld.push_back(
            {need.name, "",
             fmt::format("No setting that was measured keeps {}. The nearest is {}: {}.", need.limits,
                         nameOf(measured_[nearest]), fmt::join(broken(candidates_[nearest], need.asked), "; "))});
        continue;
      }
      const std::size_t setting = plainest(*found, need.asked);
      const auto same =
          std::find_if(answers.begin(), answers.end(), [&](const Answer& a) { return a.setting == setting; });
      if (same != answers.end()) {
        same->needs.push_back(std::move(need));
      } else {
        answers.push_back({setting, {std::move(need)}});
      }
    }
    winners_.clear();
    for (const Answer& answer : answers) winners_.push_back(answer.setting);
    if (answers.size() == 1 && unheld.empty()) {
      const std::size_t i = answers.front().setting;
      const std::string lead =
          measured_.size() == 1
              ? std::string("Only this setting was measured, and it holds every limit that is asked about here")
              : fmt::format(
                    "Take it whatever you need: of {} settings it is the fastest, and it holds every limit down to "
                    "{}",
                    measured_.size(), answers.front().needs.front().limits);
      advice_.push_back({"every need", nameOf(i), fmt::format("{}. {}", lead, described(i))});
      return;
    }
    for (const Answer& answer : answers) {
      std::vector<std::string> names;
      for (const Need& need : answer.needs) names.push_back(need.name);
      const std::size_t i = answer.setting;
      advice_.push_back({fmt::format("{}", fmt::join(names, "; ")), nameOf(i),
                         fmt::format("The fastest {}: {}", answer.needs.front().holding, described(i))});
    }
    advice_.insert(advice_.end(), unheld.begin(), unheld.end());
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
      const std::string need = fmt::format("any reason for {}", method);
      if (!undominated.empty()) {
        const auto best = *std::min_element(undominated.begin(), undominated.end(),
                                            [&](std::size_t a, std::size_t b) { return seconds(a) < seconds(b); });
        advice_.push_back({need, nameOf(best),
                           fmt::format("It answers none of the needs above, but nothing beats {} in everything: {}{}",
                                       nameOf(best), described(best), graphicsRemark(method))});
        continue;
      }
      const auto byDefault =
          std::find_if(own.begin(), own.end(), [&](std::size_t i) { return isDefault(result(i).setting); });
      const std::size_t shown =
          byDefault != own.end()
              ? *byDefault
              : *std::min_element(own.begin(), own.end(), [&](auto a, auto b) { return seconds(a) < seconds(b); });
      const std::size_t better = base_ && beats(*base_, shown) ? *base_ : *dominator(shown);
      const std::vector<std::string> losses = worse(shown, better);
      const double slower = seconds(better) > 0 ? seconds(shown) / seconds(better) : 1;
      advice_.push_back(
          {need, "",
           fmt::format(
               "{} {} {}{}: no reason to take it here.{} {}{}", nameOf(shown),
               slower > 1 + kSameTime ? fmt::format("is {} x slower than", factorText(slower)) : "is no faster than",
               base_ && better == *base_ ? baseName() : nameOf(better),
               losses.empty() ? " and no more exact" : fmt::format(" and less exact ({})", fmt::join(losses, ", ")),
               losses.empty() ? "" : awayFromEdges(shown),
               own.size() == 1 ? ""
                               : fmt::format("The same holds for each of its {} settings: another is as fast "
                                             "or faster, and as exact or more.",
                                             own.size()),
               graphicsRemark(method))});
    }
  }

  bool beats(std::size_t i, std::size_t other) const { return seconds(i) <= seconds(other) && worse(i, other).empty(); }

  // The figures of a method that draws say little where no graphics card drew.
  std::string graphicsRemark(const std::string& method) const {
    const bool software = study_.machine.renderer.find("llvmpipe") != std::string::npos ||
                          study_.machine.renderer.find("softpipe") != std::string::npos;
    if (method != "depth_camera" || !software) return "";
    return " OpenGL ran on the processor here; measure again where there is a graphics card.";
  }

  // Of the methods that do answer a need: the settings that nobody needs.
  void nameDominated() {
    std::vector<std::string> named;
    std::size_t count = 0;
    for (const std::size_t i : measured_) {
      if (std::find(judged_.begin(), judged_.end(), result(i).setting.method) != judged_.end()) continue;
      const std::optional<std::size_t> by = dominator(i);
      if (!by || std::find(winners_.begin(), winners_.end(), i) != winners_.end()) continue;
      ++count;
      if (named.size() == kMostNamed) continue;
      const double slower = seconds(*by) > 0 ? seconds(i) / seconds(*by) : 1;
      named.push_back(slower > 1 + kSameTime
                          ? fmt::format("{} ({} x slower than {}, {})", nameOf(i), factorText(slower), nameOf(*by),
                                        worse(i, *by).empty() ? "no more exact" : "less exact")
                          : fmt::format("{} (no faster than {}, less exact)", nameOf(i), nameOf(*by)));
    }
    if (named.empty()) return;
    if (count > named.size()) named.push_back(fmt::format("and {} more", count - named.size()));
    advice_.push_back(
        {"what not to take", "", fmt::format("Dominated, in speed and in exactness: {}.", fmt::join(named, "; "))});
  }

  const Study& study_;
  std::vector<std::size_t> measured_;
  std::vector<Candidate> candidates_;
  std::optional<std::size_t> base_;
  std::vector<std::size_t> winners_;
  std::vector<std::string> judged_;  // methods
  std::vector<Advice> advice_;
};

}  // namespace

std::vector<Advice> advise(const Study& study) {
  return Adviser(study).advise();
}

}  // namespace scanmill
