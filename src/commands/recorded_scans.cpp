#include "commands/recorded_scans.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "config/value.h"
#include "dataset/scan_store.h"

namespace scanmill {

std::string requiredText(const Arguments& parsed, const std::string& option, const std::string& advice) {
  std::string text = parsed.text(option);
  if (text.empty()) throw InputError(fmt::format("--{} is missing: {}", option, advice));
  return text;
}

void forEachScan(const std::vector<std::string>& paths,
                 const std::function<void(const Scan&, const std::string&)>& visit) {
  constexpr std::size_t kMostScans = 100;  // greatest number per path; callers keep all of them in memory
  for (const std::string& path : paths) {
    const ScanStore store(path);
    const std::size_t scans = store.keys().size();
    const std::size_t count = std::min(scans, kMostScans);
    if (count < scans) warn("{}: reads {} of its {} scans, evenly spaced", path, count, scans);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t i = k * scans / count;
      visit(store.decode(i, store.scans(i).front()), store.single() ? path : store.keys()[i]);
    }
  }
}

void addSimulatedOption(CommandOptions& options) {
  options.add("simulated",
              "a dataset of Scanmill with the column power, of places like the recorded ones: finds the "
              "sensor's response to power too",
              textValue(), "DATASET");
}

std::optional<FoundResponse> responseOf(const std::vector<Scan>& recorded, const Arguments& parsed) {
  const std::string dataset = parsed.text("simulated");
  if (dataset.empty()) return {};
  const ScanStore store(dataset);
  if (store.manifest() == nullptr) {
    throw InputError({dataset}, "has no manifest: --simulated needs a dataset that Scanmill has generated");
  }
  std::vector<Scan> simulated;
  forEachScan({dataset}, [&](const Scan& scan, const std::string&) { simulated.push_back(scan); });
  const ResponseFit fit = fitResponse(recorded, simulated);
  printText(
      "response: {} recorded and {} simulated surfaces; the misfit of their medians is {:.1f} % of the span "
      "of nine tenths of the recorded ones\n",
      grouped(fit.recorded), grouped(fit.simulated), 100 * fit.misfit);
  constexpr double kPoorMisfit = 0.2;  // chosen by eye
  if (fit.misfit > kPoorMisfit) {
    warn("the response describes the recording poorly: simulate places that are more like the recorded ones");
  }
  // True if the dataset has the effect with this value of the option `key`. An empty `key` or `value` is not compared.
  const auto hasEffect = [&](std::string_view effect, std::string_view key, std::string_view value) {
    return std::ranges::any_of(store.manifest()->modelled, [&](const ModelledItem& item) {
      if (item.topic != fmt::format("effect {}", effect) || item.leftOut) return false;
      const Value options = parseYaml(item.options, "the effects of " + dataset);
      const Value* const option = options.find(key);
      return key.empty() || (option != nullptr && (value.empty() || option->text == value));
    });
  };
  if (hasEffect("speckle", "", "") || hasEffect("ring_bias", "gain_sigma", "")) {
    warn(dataset +
         ": has speckle or unequal gains of lasers, so that the noise is found too small: generate it with "
         "{speckle: none} and {ring_bias: none} among `effects`");
  }
  const bool rough = hasEffect("intensity", "diffuse", "oren_nayar");
  const std::string name = std::filesystem::path(dataset).filename().string();
  return FoundResponse{.fit = fit, .yaml = responseYaml(fit, rough ? "oren_nayar" : "lambertian", name)};
}

std::filesystem::path requiredFile(const Arguments& parsed, const std::string& advice) {
  const std::filesystem::path out = requiredText(parsed, "out", advice);
  prepareOutputFile(out, parsed);
  return out;
}

}  // namespace scanmill
