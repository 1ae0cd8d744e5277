#include "viewer/font.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace scanmill {

namespace {

constexpr int kRows = 9;
constexpr int kColumns = 5;

// From ' ' to '~': a glyph is nine rows from top to bottom, each a digit of base 32 (0-9, A-V) whose five bits are the
// row's cells, the highest bit on the left.
constexpr std::array<std::string_view, 95> kGlyphs{
    "000000000", "444440400", "AAA000000", "AAVAVAA00", "4FKE5U400", "OP248J300", "CIK8LID00", "440000000", "248884200",
    "842224800", "04LEL4000", "044V44000", "000004480", "000V00000", "000000400", "11248GG00", "EHHHHHE00", "4C4444E00",
    "EH1248V00", "EH161HE00", "26AIV2200", "VGU11HE00", "68GUHHE00", "V12488800", "EHHEHHE00", "EHHF12C00", "004000400",
    "004000480", "248G84200", "00V0V0000", "842124800", "EH1240400", "EH1DLLE00", "EHHHVHH00", "UHHUHHU00", "EHGGGHE00",
    "SIHHHIS00", "VGGUGGV00", "VGGUGGG00", "EHGNHHF00", "HHHVHHH00", "E44444E00", "72222IC00", "HIKOKIH00", "GGGGGGV00",
    "HRLLHHH00", "HHPLJHH00", "EHHHHHE00", "UHHUGGG00", "EHHHLID00", "UHHUKIH00", "FGGE11U00", "V44444400", "HHHHHHE00",
    "HHHHHA400", "HHHLLLA00", "HHA4AHH00", "HHHA44400", "V1248GV00", "E88888E00", "GG8421100", "E22222E00", "4AH000000",
    "0000000V0", "840000000", "00E1FHF00", "GGUHHHU00", "00EHGHE00", "11FHHHF00", "00EHVGE00", "68S888800", "00FHHHF1E",
    "GGUHHHH00", "40C444E00", "20622222C", "GGIKOKI00", "C44444E00", "00QLLLL00", "00UHHHH00", "00EHHHE00", "00UHHHUGG",
    "00FHHHF11", "00MOGGG00", "00FGE1U00", "88S889600", "00HHHHF00", "00HHHA400", "00HHLLA00", "00HA4AH00", "00HHHHF1E",
    "00V248V00", "244844200", "444444400", "844244800", "008L20000"};

struct Stroke {
  double ax, ay, bx, by;  // cells
};

// A glyph as strokes between the centres of neighbouring cells: so it stays smooth at any size.
struct Glyph {
  std::vector<Stroke> strokes;
  double width = 2;  // cells
};

bool cell(std::string_view rows, int x, int y) {
  if (x < 0 || y < 0 || x >= kColumns || y >= kRows) return false;
  const char digit = rows[std::size_t(y)];
  const int bits = digit <= '9' ? digit - '0' : digit - 'A' + 10;
  return (bits >> (kColumns - 1 - x) & 1) != 0;
}

Glyph makeGlyph(std::string_view rows) {
  Glyph glyph;
  int left = kColumns;
  int right = -1;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      if (!cell(rows, x, y)) continue;
      left = std::min(left, x);
      right = std::max(right, x);
    }
  }
  if (right < 0) return glyph;
  glyph.width = right - left + 1;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      if (!cell(rows, x, y)) continue;
      const double cx = x - left + 0.5;
      const double cy = y + 0.5;
      glyph.strokes.push_back({cx, cy, cx, cy});
      if (cell(rows, x + 1, y)) glyph.strokes.push_back({cx, cy, cx + 1, cy});
      if (cell(rows, x, y + 1)) glyph.strokes.push_back({cx, cy, cx, cy + 1});
      for (const int side : {-1, 1}) {  // a diagonal, unless the strokes already turn the corner
        if (cell(rows, x + side, y + 1) && !cell(rows, x + side, y) && !cell(rows, x, y + 1)) {
          glyph.strokes.push_back({cx, cy, cx + side, cy + 1});
        }
      }
    }
  }
  return glyph;
}

const Glyph& glyphOf(char c) {
  static const std::vector<Glyph> glyphs = [] {
    std::vector<Glyph> made;
    made.reserve(std::size(kGlyphs));
    for (const std::string_view rows : kGlyphs) made.push_back(makeGlyph(rows));
    return made;
  }();
  const bool printable = c >= ' ' && c <= '~';
  return glyphs[std::size_t((printable ? c : '?') - ' ')];
}

// Bytes that continue a UTF-8 sequence take no room.
bool continues(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

double distance(const Stroke& s, double x, double y) {
  const double dx = s.bx - s.ax;
  const double dy = s.by - s.ay;
  const double squared = dx * dx + dy * dy;
  const double t = squared > 0 ? std::clamp(((x - s.ax) * dx + (y - s.ay) * dy) / squared, 0.0, 1.0) : 0.0;
  return std::hypot(x - s.ax - t * dx, y - s.ay - t * dy);
}

void drawGlyph(Image& image, double x, double y, const Glyph& glyph, const Rgb& color, double size) {
  constexpr double kHalfStroke = 0.55;  // cells
  const int right = static_cast<int>(std::ceil(x + (glyph.width + 1) * size));
  const int bottom = static_cast<int>(std::ceil(y + (kRows + 1) * size));
  for (int py = static_cast<int>(std::floor(y - size)); py < bottom; ++py) {
    for (int px = static_cast<int>(std::floor(x - size)); px < right; ++px) {
      if (!image.contains(px, py)) continue;
      double nearest = 1e9;
      for (const Stroke& s : glyph.strokes) {
        nearest = std::min(nearest, distance(s, (px + 0.5 - x) / size, (py + 0.5 - y) / size));
      }
      const double cover = std::clamp((kHalfStroke - nearest) * size + 0.5, 0.0, 1.0);
      if (cover > 0) image.at(px, py) = mix(image.at(px, py), color, cover);
    }
  }
}

}  // namespace

double textWidth(std::string_view text, double cell) {
  double cells = 0;
  for (const char c : text) {
    if (!continues(c)) cells += glyphOf(c).width + 1;
  }
  return std::max(cells - 1, 0.0) * cell;
}

void drawText(Image& image, double x, double y, std::string_view text, const Rgb& color, double cell) {
  for (const char c : text) {
    if (continues(c)) continue;
    const Glyph& glyph = glyphOf(c);
    drawGlyph(image, x, y, glyph, color, cell);
    x += (glyph.width + 1) * cell;
  }
}

std::string fitText(std::string_view text, double width, double cell) {
  if (textWidth(text, cell) <= width) return std::string(text);
  while (!text.empty()) {
    text.remove_suffix(1);
    std::string cut = std::string(text) + "...";
    if (textWidth(cut, cell) <= width) return cut;
  }
  return {};
}

}  // namespace scanmill
