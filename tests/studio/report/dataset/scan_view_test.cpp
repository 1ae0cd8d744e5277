#include "report/dataset/scan_view.h"

#include <nlohmann/json.hpp>

#include "base/file.h"
#include "base/hash.h"
#include "report/dataset/dataset_report.h"
#include "tests/studio/report/dataset/made_dataset.h"
#include "tests/studio/report/page/browser.h"

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

}  // namespace
}  // namespace scanmill
