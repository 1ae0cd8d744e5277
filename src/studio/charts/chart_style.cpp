#include "charts/chart_style.h"

#include <fmt/core.h>

#include <array>

namespace scanmill {

namespace {

// M. Okabe and K. Ito, Color Universal Design, 2008. Black is the ink of the page, last but one; yellow, which a white
// page swallows, is last and has a rim.
constexpr std::array<const char*, kChartColors> kOnLight{"#0072B2", "#D55E00", "#009E73", "#E69F00",
                                                         "#CC79A7", "#56B4E9", "#1f2328", "#F0E442"};
// Blue is lifted: on a dark page it has too little contrast.
constexpr std::array<const char*, kChartColors> kOnDark{"#3D9BDC", "#E8762B", "#12B886", "#E69F00",
                                                        "#CC79A7", "#7CC8F2", "#e6edf3", "#F0E442"};
constexpr std::array<const char*, kChartColors> kDashes{"",     "7 3", "2.5 3", "10 3 2 3", "5 2 2 2 2 2",
                                                        "12 4", "",    "4 4"};

// Plain rules without variables: viewers other than browsers know those.
std::string colors(const std::array<const char*, kChartColors>& palette, const char* page, const char* ink,
                   const char* muted, const char* grid, const char* axis, const char* band) {
  std::string css = fmt::format(
      ".smc .page{{fill:{0}}}.smc text{{fill:{1}}}.smc .muted{{fill:{2}}}.smc .grid{{stroke:{3}}}"
      ".smc .axis,.smc .leader{{stroke:{4}}}.smc .band{{fill:{5}}}.smc .mark,.smc .bar{{stroke:{0}}}"
      ".smc .label{{stroke:{0}}}",
      page, ink, muted, grid, axis, band);
  for (std::size_t i = 0; i < kChartColors; ++i) {
    css += fmt::format(".smc .f{0}{{fill:{1}}}.smc .s{0}{{stroke:{1}}}", i, palette[i]);
  }
  return css;
}

}  // namespace

std::string chartStyle() {
  std::string css =
      ".smc text{font-family:Helvetica,Arial,'Liberation Sans',sans-serif;font-size:11.5px}"
      ".smc .title{font-size:15px;font-weight:600}.smc .note{font-size:12px}.smc .axistitle{font-size:12px}"
      ".smc .strong{font-weight:600}.smc .nodata{font-size:16px}"
      ".smc .grid{stroke-width:1}.smc .axis{stroke-width:1}.smc .leader{stroke-width:.8;fill:none}"
      ".smc .line{fill:none;stroke-width:1.8;stroke-linejoin:round;stroke-linecap:round}.smc .wide{stroke-width:2.4}"
      ".smc .span{fill:none;stroke-width:1.3}.smc .dim{opacity:.6}.smc .mark.dim{opacity:1;stroke-width:1.4}.smc "
      ".mark{stroke-width:1}.smc .bar{stroke-width:.6}"
      ".smc .mark:hover,.smc .bar:hover{opacity:1;stroke-width:0}"
      ".smc .label{paint-order:stroke;stroke-width:2.5px;stroke-linejoin:round}";
  for (std::size_t i = 0; i < kChartColors; ++i) {
    if (*kDashes[i] != 0) css += fmt::format(".smc .line.s{}{{stroke-dasharray:{}}}", i, kDashes[i]);
  }
  css += colors(kOnLight, "#ffffff", "#1f2328", "#59636e", "#e8ebef", "#8b949e", "#f3f5f8");
  css += fmt::format("@media (prefers-color-scheme:dark){{{}}}",
                     colors(kOnDark, "#12161c", "#e6edf3", "#9aa4af", "#262d36", "#6e7681", "#1a2029"));
  return fmt::format("<style>{}</style>\n", css);
}

}  // namespace scanmill
