#include "report/tradeoff/report.h"

#include <limits>
#include <map>
#include <regex>

#include "images/images.h"
#include "study/tradeoff/study.h"
#include "tests/studio/charts/svg_check.h"
#include "tests/studio/study/tradeoff/example_study.h"
#include "tests/support/test_scene.h"
#include "viewer/color_map.h"
#include "viewer/image.h"

namespace scanmill {
namespace {

using testing::HasSubstr;
using testing::Not;

// A chart by its name.
Chart chartOf(const Study& study, const std::string& name) {
  for (const Chart& chart : studyCharts(study)) {
    if (chart.name == name) return chart;
  }
  throw std::runtime_error("no chart " + name);
}

std::string paretoSvg(const Study& study) {
  return drawSvg(chartOf(study, "pareto"));
}

// What a page shows, without the style and the scripts that it carries.
std::string pageOf(const Study& study) {
  const std::string html = studyReport(study, "out/my study");
  const std::size_t begin = html.find("<main>");
  return html.substr(begin, html.find("</main>") + 7 - begin);
}

// A page's section, by the id of its heading.
std::string sectionOf(const std::string& html, const std::string& id) {
  const std::size_t heading = html.find("<h2 id=\"" + id);
  if (heading == std::string::npos) return "";
  const std::size_t begin = html.rfind("<section", heading);
  return html.substr(begin, html.find("</section>", heading) - begin);
}

std::size_t countOf(const std::string& text, const std::string& words) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++count;
  return count;
}

// Elements open and close in order; those that HTML never closes aside.
void expectBalanced(const std::string& html) {
  std::vector<std::string> open;
  std::string text = html;
  for (std::size_t at = text.find("<script"); at != std::string::npos; at = text.find("<script")) {
    text.erase(at, text.find("</script>", at) + 9 - at);
  }
  const std::regex tags("<(/?)([a-zA-Z0-9]+)([^>]*)>");
  for (std::sregex_iterator it(text.begin(), text.end(), tags), end; it != end; ++it) {
    const std::string tag = (*it)[2], rest = (*it)[3];
    if (tag == "meta" || tag == "img" || rest.ends_with("/")) continue;
    if ((*it)[1].length() == 0) {
      open.push_back(tag);
      continue;
    }
    ASSERT_FALSE(open.empty()) << tag;
    ASSERT_EQ(open.back(), tag) << std::string(it->prefix()).substr(0, 200);
    open.pop_back();
  }
  EXPECT_TRUE(open.empty());
}

Study picturedStudy() {
  Study study = exampleStudy();
  study.pictures = {{"depth_camera", "\x89PNG not quite"}};
  return study;
}

TEST(Report, IsWellFormed) {
  const std::string html = pageOf(picturedStudy());
  expectBalanced(html);
  EXPECT_GE(countOf(html, "<svg"), 11u);
  parseSvg(paretoSvg(exampleStudy()));
}

TEST(Report, ShowsEverySettingEncodingAndFailure) {
  const Study study = picturedStudy();
  const std::string html = pageOf(study);
  for (const SettingResult& s : study.settings) {
    EXPECT_THAT(html, HasSubstr(">" + s.setting.name + "</td>"));
    if (!s.failure.empty()) continue;
    EXPECT_THAT(html, HasSubstr(escapeXml(s.setting.assignment())));
  }
  for (const EncodingResult& e : study.encodings) EXPECT_THAT(html, HasSubstr(">" + e.name + "</td>"));
  EXPECT_THAT(html, HasSubstr("not measured: Blender was not found"));
  EXPECT_THAT(html, HasSubstr("depth_camera resolution=4096: the budget of 5 min was used up"));
  for (const char* id : {"advice", "speed", "settings", "range", "edges", "classes", "things", "stages", "encodings",
                         "pictures", "left", "again"}) {
    EXPECT_THAT(html, HasSubstr(std::string("<h2 id=\"") + id));
    EXPECT_THAT(html, HasSubstr(std::string("<a href=\"#") + id));
  }
  EXPECT_THAT(html, HasSubstr("AMD EPYC 9B14, 2 threads"));
}

TEST(Report, TheCommandIsTheOneThatWasGiven) {
  Study study = exampleStudy();
  study.pipelineText += "# --set method=particle\n";
  study.pipelineFile = "my pipelines/street.yaml";
  const std::string plain = pageOf(study);
  const std::string file = "'my pipelines/street.yaml'";
  const auto shown = [](const std::string& words) { return HasSubstr(escapeXml(words)); };
  EXPECT_THAT(plain, shown("scanmill tradeoff " + file + " -o 'out/my study' --set seed=7 --set method=particle"));
  EXPECT_THAT(plain, shown("scanmill generate " + file +
                           " -o out/quickstart --set seed=7 --set 'method={ray_tracing: {simplify: 0.99}}'"))
      << "the first advice";
  EXPECT_THAT(plain, Not(HasSubstr("--budget")));
  EXPECT_THAT(plain, Not(HasSubstr("pipelines/quickstart.yaml")));
  study.budgetGiven = true;
  EXPECT_THAT(pageOf(study), shown("-o 'out/my study' --budget 5 --set seed=7"));
}

TEST(ReportFigures, ColoursAreOfMethodsWhateverTheirOrder) {
  EXPECT_EQ(methodColor("ray_tracing"), 0u);
  EXPECT_EQ(methodColor("depth_camera"), 1u);
  EXPECT_EQ(methodColor("particle"), 2u);
  EXPECT_THAT(settingColors({"particle", "ray_tracing", "particle", "ray_tracing", "depth_camera", "particle"}),
              testing::ElementsAre(2, 0, 3, 4, 1, 5));
  const std::string marks = R"(class="mark f0)";
  Study study = studyOf({{"ray_tracing", "instancing=always", 5, 0, 1, 0}});
  EXPECT_THAT(paretoSvg(study), HasSubstr(marks));
  study.settings[0].setting.method = "particle";
  EXPECT_THAT(paretoSvg(study), Not(HasSubstr(marks)));
}

// So many settings in one place that most labels are left out.
TEST(Report, TheParetoChartAlwaysNamesDefaults) {
  Study study = studyOf({});
  for (int i = 0; i < 300; ++i) {
    const double a = i % 20 * 0.012, b = i / 20 * 0.03;
    study.settings.push_back(exampleResult(
        {"particle", "voxel_m=0." + std::to_string(1000 + i), 10 * std::exp(a), 0.1 * std::exp(b), 0.9, 0.01}));
  }
  study.settings.push_back(exampleResult({"particle", "", 10 * std::exp(0.12), 0.1 * std::exp(0.22), 0.9, 0.01}));
  study.settings.push_back(exampleResult({"ray_tracing", "", 10 * std::exp(0.1), 0.1 * std::exp(0.2), 0.9, 0.01}));
  const std::vector<std::string> labels = textsOf(paretoSvg(study), "label");
  EXPECT_LT(labels.size(), 150u);
  EXPECT_THAT(labels, testing::Contains("particle"));
  EXPECT_THAT(labels, testing::Contains("ray tracing"));
}

TEST(Report, HostileTextStaysText) {
  const std::string hostile = "</title></script><img src=x onerror='alert(1)'>&\"";
  Study study = picturedStudy();
  for (SettingResult& s : study.settings) {
    s.setting.name += hostile;
    s.setting.options = "{a: " + hostile + "}";
    if (!s.failure.empty()) s.failure += hostile;
    s.measured.warnings = {hostile};
    for (ErrorGroup& g : s.measured.errors.byClass) g.name += hostile;
    if (!s.measured.cost.stages.empty()) s.measured.cost.stages[hostile] = 1e-3;
  }
  for (EncodingResult& e : study.encodings) e.name += hostile, e.format += hostile;
  study.pipelineName = study.pipelineText = study.pipelineFile = study.machine.processor = study.machine.renderer =
      study.date = hostile;
  study.programVersion = study.scene.key = study.sensors[0] = study.leftOut[0] = hostile;
  study.pictures[0].setting = hostile;
  study.commonStages[hostile] = 1;
  const std::string html = pageOf(study);
  EXPECT_THAT(html, Not(HasSubstr("<img src=x")));
  EXPECT_EQ(countOf(studyReport(study, "out"), "</script>"), 1u) << "the program's";
  EXPECT_EQ(countOf(html, "<img"), 1u);
  expectBalanced(html);
}

TEST(Report, OfNothingSaysSo) {
  const std::string html = pageOf(Study{});
  expectBalanced(html);
  EXPECT_THAT(html, HasSubstr("No setting was measured."));
  EXPECT_THAT(html, Not(HasSubstr("<svg"))) << "sections without data are left out";
  EXPECT_THAT(html, Not(HasSubstr("<h2 id=\"advice\"")));
  EXPECT_THAT(textsOf(paretoSvg(Study{}), "nodata"), testing::ElementsAre("no data"));
}

TEST(Report, OfFailuresOrOneSettingIsWhole) {
  Study study = exampleStudy();
  study.settings.resize(1);
  std::string html = pageOf(study);
  expectBalanced(html);
  EXPECT_THAT(sectionOf(html, "advice"), HasSubstr("<h3>ray_tracing</h3>"));
  EXPECT_THAT(html, HasSubstr("<h2 id=\"speed\""));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  study = exampleStudy();
  for (SettingResult& s : study.settings) s.measured = {}, s.failure = "nothing runs here";
  html = pageOf(study);
  expectBalanced(html);
  EXPECT_EQ(countOf(html, "not measured: nothing runs here"), study.settings.size());
}

// 131,072 beams in 10 ms are 13.1 M a second.
TEST(Report, EveryStageHasItsTimeAndItsBeams) {
  Study study = exampleStudy();
  study.settings.resize(3);
  study.settings[1].measured.cost.stages = {{"read_back", 0.01}, {"render", 0}, {"wait", 0}};
  study.settings[2].measured.cost.stages = {{"march", 1.024}, {"render", 1e-3}};
  study.commonStages = {{"effects", 0.002}, {"encode pcd", 0.016384}};
  const std::string table = sectionOf(pageOf(study), "stages");
  for (const char* stage : {"read back", "render", "march", "effects, one thread", "encode pcd, one thread"}) {
    EXPECT_THAT(table, HasSubstr(std::string("<th colspan=\"2\">") + stage + "</th>"));
  }
  EXPECT_THAT(table, HasSubstr(">10 ms</td><td data-v=\"13107200\">13.1 M</td>"));
  EXPECT_THAT(table, HasSubstr(">1.02 s</td><td data-v=\"128000\">128 k</td>"));
  EXPECT_EQ(countOf(table, ">2 ms</td><td data-v=\"65536000\">65.5 M</td>"), 3u) << "the same for each setting";
  EXPECT_EQ(countOf(table, ">16.4 ms</td><td data-v=\"8000000\">8 M</td>"), 3u);
  EXPECT_THAT(table, Not(HasSubstr("wait"))) << "a stage that takes nothing by any setting";
}

TEST(Report, SettingsThatHitNothingHaveNoErrors) {
  Study study = exampleStudy();
  Measurement& m = study.settings[1].measured;
  m.errors = {};
  m.errors.all.beams = 1000;
  m.errors.all.falseNegatives = 900;
  m.errors.all.bothMiss = 100;
  m.cost.scanSeconds = 0;
  const std::string html = pageOf(study);
  EXPECT_THAT(html, Not(HasSubstr("nan")));
}

TEST(Report, TheParetoChartHoldsEverySettingOnceAndItsFront) {
  const Study study = exampleStudy();
  const std::string svg = paretoSvg(study);
  EXPECT_EQ(dotsOf(svg).size(), measuredSettings(study).size());
  EXPECT_EQ(elementsOf(svg, "line").size(), 1u);
  const std::vector<std::string> labels = textsOf(svg, "strong");
  EXPECT_EQ(labels.size(), frontOf(study, rangeP99).size()) << "all of the front are named";
  EXPECT_THAT(labels, testing::Contains("simplify=0.1"));
}

TEST(ReportFigures, TheShownSettingsAreDefaultsThenTheFastest) {
  const Study study = exampleStudy();
  std::vector<std::string> names;
  for (const std::size_t i : shownSettings(study, 6)) names.push_back(study.settings[i].setting.name);
  EXPECT_THAT(names, testing::ElementsAre("ray_tracing", "depth_camera", "particle", "ray_tracing simplify=0.1",
                                          "depth_camera sampling=nearest resolution=512",
                                          "particle levels=1 voxel_m=1 refine=none"));
}

TEST(ReportFigures, ACommandLineSurvivesQuotes) {
  EXPECT_EQ(setArgument({"particle", "particle", "{}"}), "--set 'method=particle'");
  EXPECT_EQ(setArgument({"x", "particle", "{cache: it's}"}), "--set 'method={particle: {cache: it'\\''s}}'");
}

constexpr Rgb kFalseNegative{255, 70, 70};
constexpr Rgb kFalsePositive{255, 255, 255};
constexpr Rgb kOtherLabel{255, 150, 220};
constexpr double kDarkest = 0.15;  // of the colour map: no error

// A cylinder of points 10 m around the sensor, all of one thing.
TrueShot cylinder() {
  TrueShot truth;
  truth.shot = shotAt(spinning(32, 180, -20, 20));
  truth.shot.sample = "yard-s1-drive-000002";
  Hits& hits = truth.truth.hits;
  hits.reset(32, 180, kErrorChannels);
  std::ranges::fill(hits.range, 10.0f);
  std::ranges::fill(hits.instance, 3u);
  std::ranges::fill(hits.semantic, std::uint16_t{2});
  std::ranges::fill(hits.incidence, 0.0f);
  truth.truth.range.assign(hits.size(), 10.0);
  return truth;
}

struct Drawn {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::map<Rgb, std::size_t> pixels;  // of each colour
};

Drawn drawn(const TrueShot& truth, const Hits& tested) {
  const DecodedImage image = decodeImage(drawErrors(truth, tested), "errors.png");
  Drawn counted{image.width, image.height, {}};
  for (std::size_t p = 0; p < image.rgba.size(); p += 4) {
    ++counted.pixels[{image.rgba[p], image.rgba[p + 1], image.rgba[p + 2]}];
  }
  return counted;
}

// Errors of every kind fill the picture with the colour that the legend gives them.
TEST(ErrorPicture, EveryKindOfErrorHasItsColor) {
  const TrueShot truth = cylinder();
  const Hits& real = truth.truth.hits;
  Drawn exact = drawn(truth, real);

  Hits unhit = real;
  std::ranges::fill(unhit.range, kMiss);
  Hits relabelled = real;
  std::ranges::fill(relabelled.semantic, std::uint16_t{1});
  Hits othered = real;
  std::ranges::fill(othered.instance, 4u);
  Hits off = real;
  for (float& range : off.range) range += 2;  // more than the scale holds
  Hits slightly = real;
  for (float& range : slightly.range) range += 0.03162f;  // 10^-1.5 m: in the middle of the scale
  TrueShot nothing = truth;
  std::ranges::fill(nothing.truth.hits.range, kMiss);
  std::ranges::fill(nothing.truth.range, std::numeric_limits<double>::infinity());

  const auto filled = [&](Drawn picture, const Rgb& color) {
    return static_cast<double>(picture.pixels[color]) - static_cast<double>(exact.pixels[color]);
  };
  EXPECT_GT(filled(drawn(truth, unhit), kFalseNegative), 3000);
  EXPECT_GT(filled(drawn(nothing, real), kFalsePositive), 3000);
  EXPECT_GT(filled(drawn(truth, relabelled), kOtherLabel), 3000);
  EXPECT_GT(filled(drawn(truth, othered), kOtherLabel), 3000);
  EXPECT_GT(filled(drawn(truth, off), viridis(1)), 3000);
  EXPECT_GT(exact.pixels[viridis(kDarkest)], 3000u);
  Drawn middle = drawn(truth, slightly);
  EXPECT_LT(middle.pixels[viridis(kDarkest)], 3000u);
  EXPECT_LT(middle.pixels[viridis(1)], 3000u);
}

TEST(ErrorPicture, ScansWithoutAnyHitAreDrawnToo) {
  TrueShot nothing = cylinder();
  std::ranges::fill(nothing.truth.hits.range, kMiss);
  std::ranges::fill(nothing.truth.range, std::numeric_limits<double>::infinity());
  EXPECT_EQ(drawn(nothing, nothing.truth.hits).width, 1200u);
}

}  // namespace
}  // namespace scanmill
