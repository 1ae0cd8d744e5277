#include <gmock/gmock.h>

#include "report/page/page.h"
#include "tests/studio/report/page/browser.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

// Acts as a reader does, and tells what came of it.
constexpr const char* kReader = R"({
const tell = (name, value) => { document.body.dataset[name] = value; };
window.addEventListener('error', event => tell('error', event.message));
const canvases = [...document.querySelectorAll('canvas.plot')], charts = canvases.map(canvas => Chart.getChart(canvas));
const inked = canvas => {
  const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  return data.some(value => value > 0);
};
tell('drawn', canvases.filter(inked).length);
const [first, second] = charts, canvas = canvases[0], {x, y} = first.getDatasetMeta(0).data[1];
const at = (type, left, top) => canvas.dispatchEvent(new PointerEvent(type, {bubbles: true, button: 0, pointerType: 'mouse',
  clientX: canvas.getBoundingClientRect().left + left, clientY: canvas.getBoundingClientRect().top + top}));
const hover = () => canvas.dispatchEvent(new MouseEvent('mousemove', {bubbles: true,
  clientX: canvas.getBoundingClientRect().left + x, clientY: canvas.getBoundingClientRect().top + y}));
// Events wait for the next frame, which comes late where the machine has other work.
const whenTold = (turns, then) => {
  if (first.tooltip.body?.length || turns === 0) return then();
  hover();
  setTimeout(() => whenTold(turns - 1, then), 100);
};
whenTold(40, () => {
tell('tooltip', first.tooltip.body?.map(line => line.lines.join('/')).join());
const buttons = document.querySelectorAll('.legend button');
tell('legend', [...buttons].map(button => button.textContent).join());
tell('zero', first.getDatasetMeta(0).data[2].y > first.scales.y.getPixelForValue(first.axes.y.band));
tell('ticks', first.scales.y.ticks.map(tick => tick.label).join(' '));
const before = first.scales.x.max;
const {left, top, width, height} = first.chartArea;
at('pointerdown', left + 5, top + 5);
at('pointermove', left + width / 2, top + height / 2);
at('pointerup', left + width / 2, top + height / 2);
tell('zoomed', first.scales.x.max < before);
canvas.dispatchEvent(new MouseEvent('dblclick', {bubbles: true}));
tell('whole', first.scales.x.max === before);
buttons[0].click();
tell('hidden', first.isDatasetVisible(0) + ',' + first.isDatasetVisible(1) + ',' + first.isDatasetVisible(2));
const bars = second.getDatasetMeta(0).data, others = second.getDatasetMeta(1).data;
tell('stacked', Math.abs(bars[1].x - others[1].base) < 0.01 && bars[0].y < bars[1].y);
});
})";

TEST(ChartsInBrowser, AnswerToTheMouse) {
  if (!hasBrowser()) GTEST_SKIP() << "Chromium is not installed";
  Chart lines{.name = "lines", .title = "Lines"};
  lines.x.names = {"near", "middle", "far"};
  lines.y = {.title = "error", .scale = AxisScale::Log, .unit = "m", .zero = "exact"};
  lines.series = {{.name = "one",
                   .mark = ChartMark::LineAndDots,
                   .points = {{0, 0.1}, {1, 1}, {2, 0}},
                   .spans = {{0.05, 0.2}, {0.5, 2}, {NAN, NAN}},
                   .labels = {"a", "b", "c"},
                   .details = {"", "one in the middle\n1 m", ""}},
                  {.name = "one", .points = {{1, 0.3}}},
                  {.name = "other", .color = 1, .mark = ChartMark::Line, .points = {{0, 0.01}, {2, 0.5}}}};
  Chart stacked{.name = "stacked", .title = "Stacked", .stacked = true};
  stacked.y.names = {"first", "second"};
  stacked.series = {{.name = "left", .mark = ChartMark::Bars, .points = {{3, 0}, {1, 1}}},
                    {.name = "right", .color = 1, .mark = ChartMark::Bars, .points = {{2, 0}, {6, 1}}}};
  const Json values{{"title", "charts"}, {"charts", chartValues({lines, stacked})}};
  const TemporaryFolder folder;
  const std::string page =
      folder.write("page.html", fillPage("{{#figures}}lines stacked{{/figures}}", values, {"", {kReader}})).string();
  const std::string body = bodyInBrowser(folder.path(), page, {"--disable-gpu"});
  EXPECT_EQ(dataOf(body, "error"), "absent");
  EXPECT_EQ(dataOf(body, "drawn"), "2");
  EXPECT_EQ(dataOf(body, "legend"), "one,other,left,right");
  EXPECT_EQ(dataOf(body, "zero"), "true") << "what is exact lies in the band beside the axis";
  EXPECT_THAT(dataOf(body, "ticks"), testing::AllOf(testing::StartsWith("exact"), testing::HasSubstr("100 mm")));
  EXPECT_EQ(dataOf(body, "zoomed"), "true");
  EXPECT_EQ(dataOf(body, "whole"), "true");
  EXPECT_EQ(dataOf(body, "hidden"), "false,false,true") << "series of one name go together";
  EXPECT_EQ(dataOf(body, "stacked"), "true");
  EXPECT_EQ(dataOf(body, "tooltip"), "one in the middle/1 m");
}

}  // namespace
}  // namespace scanmill
