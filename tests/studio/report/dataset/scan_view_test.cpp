#include "report/dataset/scan_view.h"

#include <nlohmann/json.hpp>
#include <set>

#include "base/file.h"
#include "base/hash.h"
#include "base/process.h"
#include "base/random.h"
#include "report/dataset/dataset_report.h"
#include "tests/studio/report/dataset/made_dataset.h"

namespace scanmill {
namespace {

using Json = nlohmann::json;

std::vector<std::uint32_t> numbersIn(const Json& column) {
  const std::string bytes = fromBase64(column.at("data").get<std::string>()).value();
  const std::string type = column.at("type");
  const std::size_t size = type == "u8" ? 1 : type == "u16" ? 2 : 4;
  std::vector<std::uint32_t> numbers(bytes.size() / size, 0);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    numbers[i / size] |= std::uint32_t{static_cast<std::uint8_t>(bytes[i])} << (8 * (i % size));
  }
  return numbers;
}

Scan largeScan(std::size_t count) {
  Scan scan;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.001 * double(i);
    scan.position.push_back(Vec3f(Vec3d{60 * std::cos(t), 40 * std::sin(1.7 * t), 5 * std::sin(0.3 * t)}));
    scan[kLabel].push_back(static_cast<std::uint16_t>(i % 3 == 0 ? 7 : 65535));
    scan[kInstance].push_back(i % 3 == 0 ? 0 : 70000 + static_cast<std::uint32_t>(i % 300));
    scan[kIntensity].push_back(static_cast<float>(0.5 + 0.5 * std::sin(t)));
    scan[kRing].push_back(static_cast<std::uint16_t>(i % 128));
  }
  return scan;
}

TEST(ScanView, PointsComeBackWithinHalfAStep) {
  const Scan scan = largeScan(5000);
  const Json made = Json::parse(scanView({{"a", scan}}, testManifest().ontology)).at("scans").at(0);
  EXPECT_EQ(made.at("points"), 5000);
  EXPECT_EQ(made.at("shown"), 5000);
  const std::vector<std::uint32_t> places = numbersIn(made.at("position")), classes = numbersIn(made.at("class")),
                                   instances = numbersIn(made.at("instance"));
  ASSERT_EQ(places.size(), 15000u);
  const Json& low = made.at("box").at("low");
  const Json& step = made.at("box").at("step");
  for (std::size_t i = 0; i < 5000; ++i) {
    const double xyz[] = {scan.position[i].x, scan.position[i].y, scan.position[i].z};
    for (std::size_t c = 0; c < 3; ++c) {
      const double size = step.at(c).get<double>();
      EXPECT_LT(size, 0.002);  // 120 m in 65535 steps
      EXPECT_NEAR(low.at(c).get<double>() + size * places[3 * i + c], xyz[c], 0.501 * size);
    }
    EXPECT_EQ(made.at("classes").at(classes[i]).at("id"), scan[kLabel][i]);
    EXPECT_EQ(made.at("instances").at("ids").at(instances[i]), scan[kInstance][i]);
  }
  const Json& intensity = made.at("values").at(0);
  EXPECT_EQ(intensity.at("name"), "intensity");
  const std::vector<std::uint32_t> values = numbersIn(intensity);
  for (std::size_t i = 0; i < 5000; ++i) {
    EXPECT_NEAR(intensity.at("low").get<double>() + intensity.at("step").get<double>() * values[i], scan[kIntensity][i],
                1e-5);
  }
  const Json& ring = made.at("values").at(1);
  EXPECT_EQ(ring.at("type"), "u8");
  EXPECT_EQ(numbersIn(ring)[1234], 1234u % 128);
}

TEST(ScanView, LargeScansAreThinned) {
  Scan scan = largeScan(150'000);
  scan.position[10] = {NAN, NAN, NAN};
  for (std::uint32_t& id : scan[kInstance]) id %= 30;  // none of them small
  const Json made = Json::parse(scanView({{"a", scan}}, testManifest().ontology)).at("scans").at(0);
  EXPECT_EQ(made.at("points"), 149'999);
  EXPECT_EQ(made.at("shown"), kMostViewedPoints);
  std::uint64_t counted = 0;
  for (const Json& c : made.at("classes")) counted += c.at("points").get<std::uint64_t>();
  EXPECT_EQ(counted, 149'999u);  // of the whole scan
  const std::vector<std::uint32_t> classes = numbersIn(made.at("class"));
  EXPECT_EQ(classes.size(), kMostViewedPoints);
}

TEST(ScanView, WhatIsMissingIsLeftOut) {
  Scan scan;
  scan.position = {{1, 2, 3}};
  const Json made = Json::parse(scanView({{"a", scan}}, Ontology())).at("scans").at(0);
  EXPECT_FALSE(made.contains("class") || made.contains("instance"));
  EXPECT_TRUE(made.at("values").empty());
  EXPECT_EQ(made.at("box").at("low"), Json({1.0, 2.0, 3.0}));
  EXPECT_EQ(Json::parse(scanView({{"a", Scan()}}, Ontology())).at("scans").at(0).at("shown"), 0);
  EXPECT_EQ(scanView({}, Ontology()), "");
}

TEST(ScanView, NamesCannotEndTheData) {
  Ontology ontology = testManifest().ontology;
  ontology.classes[1].name = "</script><!--\xFF";
  Scan scan;
  scan.position = {{1, 2, 3}};
  scan[kLabel] = {7};
  const std::string text = scanView({{"</SCRIPT>", scan}}, ontology);
  EXPECT_EQ(text.find('<'), std::string::npos);
  const Json data = Json::parse(text);
  EXPECT_EQ(data.at("scans").at(0).at("title"), "</SCRIPT>");
  EXPECT_EQ(data.at("scans").at(0).at("classes").at(0).at("name"), "</script><!--\xEF\xBF\xBD");
}

bool hasBrowser() {
  return !findProgram("chromium").empty();
}

// The <body ...> of a page once its scripts have run. The browser keeps its files in `folder`.
std::string bodyInBrowser(const std::filesystem::path& folder, const std::string& page,
                          const std::vector<std::string>& flags = {}) {
  std::vector<std::string> command{"chromium",
                                   "--headless=new",
                                   "--no-sandbox",
                                   "--disable-quic",
                                   "--no-first-run",
                                   "--disable-background-networking",
                                   "--disable-component-update",
                                   "--disable-sync",
                                   "--window-size=1200,2400",
                                   "--virtual-time-budget=5000",
                                   "--dump-dom",
                                   "--user-data-dir=" + (folder / "profile").string()};
  command.insert(command.end(), flags.begin(), flags.end());
  command.push_back("file://" + page);
  Process browser(command, {{"HOME", folder.string()}});
  std::string dom;
  while (const auto line = browser.readLine(120)) dom += *line + "\n";
  browser.wait(60);
  const std::size_t begin = dom.find("<body");
  return begin == std::string::npos ? "" : dom.substr(begin, dom.find('>', begin) - begin);
}

// The attribute data-NAME of such a body.
std::string dataOf(const std::string& body, const std::string& name) {
  const std::string mark = "data-" + name + "=\"";
  const std::size_t begin = body.find(mark);
  if (begin == std::string::npos) return "absent";
  return body.substr(begin + mark.size(), body.find('"', begin + mark.size()) - begin - mark.size());
}

// In a browser, as somebody opens it.
class InBrowser : public testing::Test {
 protected:
  void SetUp() override {
    if (!hasBrowser()) GTEST_SKIP() << "Chromium is not installed";
    writeMadeDataset(folder_.path() / "made", soundSamples());
    report_ = examineDataset(folder_.path() / "made", {.samples = 2, .quiet = true});
    page_ = datasetPage(report_);
  }

  std::string body(const std::vector<std::string>& flags) {
    return bodyInBrowser(folder_.path(), folder_.write("page.html", page_).string(), flags);
  }

  // Has the view's script end with scan_view_check.js, which tells what it has drawn.
  void addCheck() {
    const std::string end = "dataset.scanView = 'ready';\n", policy = "<meta http-equiv=\"Content-Security-Policy\"";
    page_.insert(page_.find(end) + end.size(), readFile(std::filesystem::path(SCANMILL_SOURCE_DIR) /
                                                        "tests/studio/report/dataset/scan_view_check.js"));
    page_.erase(page_.find(policy), page_.find('>', page_.find(policy)) + 1 - page_.find(policy));
  }

  TemporaryFolder folder_;
  DatasetReport report_;
  std::string page_;
};

TEST_F(InBrowser, DrawsHidesAndPicks) {
  addCheck();
  const std::string body = this->body({"--use-angle=swiftshader", "--enable-unsafe-swiftshader"});
  if (dataOf(body, "scan-view") == "unavailable") GTEST_SKIP() << "this Chromium has no WebGL";
  ASSERT_EQ(dataOf(body, "scan-view"), "ready") << body;
  EXPECT_EQ(dataOf(body, "test-points"), "25");
  EXPECT_EQ(dataOf(body, "test-class"), "road");
  EXPECT_EQ(dataOf(body, "test-left"), "5");
  EXPECT_GE(std::stoi(dataOf(body, "test-before")), 20);
  EXPECT_EQ(dataOf(body, "test-hidden"), "0");
  EXPECT_EQ(dataOf(body, "test-other"), "5");  // the road is hidden in the other scan too
  EXPECT_EQ(dataOf(body, "test-again"), dataOf(body, "test-before"));
  EXPECT_EQ(dataOf(body, "test-alone"), "20");
  EXPECT_EQ(dataOf(body, "test-all"), "25");
  // x to the right, y up: 10 m are 0.21 of half the height of 90 m * tan(55 degrees / 2).
  EXPECT_EQ(dataOf(body, "test-above"), "0.21,0.00 0.00,0.21");
  // The point that is nearest to the eye, behind and above the sensor: the first of the road, and what it is.
  const std::string wanted = dataOf(body, "test-wanted");
  EXPECT_LT(std::stod(dataOf(body, "test-offset")), 0.01);
  EXPECT_EQ(dataOf(body, "test-picked"), wanted);
  EXPECT_EQ(dataOf(body, "test-clicked"), wanted);
  EXPECT_EQ(wanted, "class road\nno instance\nx 3.00  y 0.00  z -1.50 m\nintensity 0\nring 0\nrange 3.35 m");
}

TEST_F(InBrowser, SaysSoWithoutWebGl) {
  EXPECT_EQ(dataOf(body({"--disable-3d-apis", "--disable-gpu"}), "scan-view"), "unavailable");
}

// A sensor 2 m above level ground, as many points in every step of elevation; without labels.
Scan groundScan(std::size_t count) {
  Scan scan;
  for (std::size_t i = 0; i < count; ++i) {
    const RandomBlock random = randomBlock({.scene = 1, .beam = static_cast<std::uint32_t>(i)});
    const double down = radians(1.5 + 30 * uniform(random[0])), azimuth = 2 * kPi * uniform(random[1]);
    const double away = 2 / std::tan(down);
    scan.position.push_back(Vec3f(Vec3d{away * std::cos(azimuth), away * std::sin(azimuth), -2}));
  }
  return scan;
}

std::size_t countBetween(const Scan& scan, const std::vector<std::size_t>& points, double from, double to) {
  return static_cast<std::size_t>(std::ranges::count_if(points, [&](std::size_t i) {
    const double away = length(Vec3d(scan.position[i]));
    return away >= from && away < to;
  }));
}

std::vector<std::size_t> everyPoint(const Scan& scan) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (isFinite(scan.position[i])) all.push_back(i);
  }
  return all;
}

TEST(ScanThinning, SmallScansStayWhole) {
  Scan scan = groundScan(500);
  scan.position[7] = {NAN, NAN, NAN};
  EXPECT_EQ(pointsToView(scan, 499), everyPoint(scan));
  EXPECT_TRUE(pointsToView(Scan(), 10).empty());
}

TEST(ScanThinning, FarPointsStayAndNearOnesAreThinnedByTheSquare) {
  const Scan scan = groundScan(50'000);
  const std::vector<std::size_t> kept = pointsToView(scan, 15'000), all = everyPoint(scan);
  EXPECT_NEAR(double(kept.size()), 15'000, 1);
  EXPECT_LE(kept.size(), 15'000u);
  EXPECT_TRUE(std::ranges::is_sorted(kept));
  EXPECT_EQ(std::set<std::size_t>(kept.begin(), kept.end()).size(), kept.size());
  EXPECT_EQ(countBetween(scan, kept, 40, 100), countBetween(scan, all, 40, 100));
  const auto share = [&](double from, double to) {
    return double(countBetween(scan, kept, from, to)) / double(countBetween(scan, all, from, to));
  };
  EXPECT_NEAR(share(6, 6.3) / share(4, 4.2), 2.25, 0.3);
  EXPECT_EQ(pointsToView(scan, 15'000), kept);
}

TEST(ScanThinning, SmallThingsAndRareClassesStayWhole) {
  Scan scan = groundScan(30'000);
  scan[kLabel].assign(scan.size(), 1);
  scan[kInstance].assign(scan.size(), 0);
  for (std::size_t i = 0; i < 300; ++i) {
    scan.position[50 * i] = {2, 0.01f * float(i), -2};  // near: thinned but for its id
    scan[kInstance][50 * i] = 9;
    scan.position[50 * i + 1] = {2, 0.01f * float(i), -2};
    scan[kLabel][50 * i + 1] = 3;
    scan.position[50 * i + 2] = {2, 0.01f * float(i), -2};
  }
  std::size_t thing = 0, rare = 0, plain = 0;
  for (const std::size_t i : pointsToView(scan, 6'000)) {
    thing += scan[kInstance][i] == 9;
    rare += scan[kLabel][i] == 3;
    plain += i % 50 == 2 && i < 15'000;
  }
  EXPECT_EQ(thing, 300u);
  EXPECT_EQ(rare, 300u);
  EXPECT_LT(plain, 30u);
}

// Many small things cannot displace all else.
TEST(ScanThinning, HalfIsLeftForTheRest) {
  Scan scan = groundScan(20'000);
  for (std::size_t i = 0; i < scan.size(); ++i) scan[kInstance].push_back(i < 10'000 ? 1 + std::uint32_t(i / 500) : 0);
  std::size_t without = 0;
  const std::vector<std::size_t> kept = pointsToView(scan, 4'000);
  for (const std::size_t i : kept) without += scan[kInstance][i] == 0;
  EXPECT_NEAR(double(kept.size()), 4'000, 1);
  EXPECT_GE(without, 500u);
}

TEST(ScanThinning, PointsInOnePlaceAreThinnedToo) {
  Scan scan;
  scan.position.assign(5000, Vec3f{0, 0, 0});
  EXPECT_NEAR(double(pointsToView(scan, 1000).size()), 1000, 1);
}

}  // namespace
}  // namespace scanmill
