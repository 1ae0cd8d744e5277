#include "viewer/window/hud_paint.h"

#include <array>
#include <map>
#include <optional>
#include <utility>

#include "viewer/font.h"

namespace scanmill {

namespace {

// Color over what is there; neither is premultiplied.
void blend(Rgba& under, const Rgba& over) {
  const int alpha = over[3];
  if (alpha == 0) return;
  if (alpha == 255 || under[3] == 0) {
    under = over;
    return;
  }
  const int kept = under[3] * (255 - alpha);  // 255 times what the lower one still counts
  const int sum = alpha * 255 + kept;
  for (std::size_t c = 0; c < 3; ++c) {
    under[c] = static_cast<std::uint8_t>((over[c] * alpha * 255 + under[c] * kept + sum / 2) / sum);
  }
  under[3] = static_cast<std::uint8_t>((sum + 127) / 255);
}

Rgba covered(const Rgb& color, double cover) {
  return withAlpha(color, static_cast<std::uint8_t>(std::lround(255 * std::clamp(cover, 0.0, 1.0))));
}

// How much of each pixel a letter covers, as drawText() draws it.
struct Glyph {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> cover;
};

constexpr int kGlyphMargin = 2;  // px around a letter, for its smooth edges
constexpr int kPhases = 4;       // letters stand at every fourth of a pixel
constexpr int kRowsOfCells = 9;
constexpr char kFirstLetter = ' ';
constexpr char kLastLetter = '~';
constexpr std::size_t kLetters = kLastLetter - kFirstLetter + 1;

// The letters of one size, drawn when they are first wanted.
struct Letters {
  std::array<std::array<std::optional<Glyph>, kPhases>, kLetters> glyphs;
  std::array<double, kLetters> advance{};

  explicit Letters(double cell) {
    for (std::size_t i = 0; i < kLetters; ++i) advance[i] = textWidth(letter(i), cell) + cell;
  }
  static std::string letter(std::size_t i) { return {static_cast<char>(kFirstLetter + static_cast<int>(i))}; }

  const Glyph& glyph(std::size_t i, std::size_t phase, double cell) {
    std::optional<Glyph>& kept = glyphs[i][phase];
    if (kept) return *kept;
    Image drawn(static_cast<int>(std::ceil(advance[i])) + 2 * kGlyphMargin + 1,
                static_cast<int>(std::ceil(kRowsOfCells * cell)) + 2 * kGlyphMargin, {0, 0, 0});
    drawText(drawn, kGlyphMargin + static_cast<double>(phase) / kPhases, kGlyphMargin, letter(i), {255, 255, 255},
             cell);
    kept.emplace(Glyph{drawn.width, drawn.height, {}});
    for (const Rgb& p : drawn.pixels) kept->cover.push_back(p[0]);
    return *kept;
  }
};

Letters& lettersOf(double cell) {
  constexpr std::size_t kMostSizes = 16;  // a window that is being resized asks for ever new ones
  thread_local std::map<double, Letters> kept;
  const auto found = kept.find(cell);
  if (found != kept.end()) return found->second;
  if (kept.size() >= kMostSizes) kept.clear();
  return kept.emplace(cell, Letters(cell)).first->second;
}

bool continuesLetter(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

// Bytes of the text's first letter.
std::size_t firstLetter(std::string_view text) {
  std::size_t size = 1;
  while (size < text.size() && continuesLetter(text[size])) ++size;
  return size;
}

// Bytes of the longest beginning that fits; at least one letter.
std::size_t fittingBytes(std::string_view text, double width, double cell) {
  std::size_t bytes = firstLetter(text);
  double used = textWidth(text.substr(0, bytes), cell);
  while (bytes < text.size()) {
    const std::size_t next = firstLetter(text.substr(bytes));
    used += textWidth(text.substr(bytes, next), cell) + cell;
    if (used > width) break;
    bytes += next;
  }
  return bytes;
}

}  // namespace

PixelRect HudPaint::inside(const PixelRect& rect) const {
  const int left = std::clamp(rect.left, 0, width_);
  const int top = std::clamp(rect.top, 0, height_);
  return {left, top, std::clamp(rect.left + rect.width, left, width_) - left,
          std::clamp(rect.top + rect.height, top, height_) - top};
}

void HudPaint::fill(const PixelRect& rect, const Rgba& color) {
  const PixelRect part = inside(rect);
  for (int y = part.top; y < part.top + part.height; ++y) {
    Rgba* const first = row(y) + part.left;
    if (color[3] == 255) {
      std::fill_n(first, part.width, color);
    } else {
      for (int x = 0; x < part.width; ++x) blend(first[x], color);
    }
  }
}

void HudPaint::frame(const PixelRect& rect, const Rgba& color, int thickness) {
  const int t = std::min({thickness, rect.width, rect.height});
  fill({rect.left, rect.top, rect.width, t}, color);
  fill({rect.left, rect.top + rect.height - t, rect.width, t}, color);
  fill({rect.left, rect.top + t, t, rect.height - 2 * t}, color);
  fill({rect.left + rect.width - t, rect.top + t, t, rect.height - 2 * t}, color);
}

void HudPaint::panel(const PixelRect& rect, const Rgb& edge, double cell) {
  const int t = std::max(toPixels(0.6, cell), 1);
  fill({rect.left + t, rect.top + t, rect.width - 2 * t, rect.height - 2 * t}, withAlpha(kPanel, kPanelAlpha));
  frame(rect, opaque(edge), t);
}

void HudPaint::text(double x, double y, std::string_view text, const Rgb& color, double cell) {
  if (!(std::abs(x) < 1e6) || !(std::abs(y) < 1e6)) return;
  const int top = static_cast<int>(std::lround(y)) - kGlyphMargin;
  Letters& letters = lettersOf(cell);
  for (const char c : text) {
    if (continuesLetter(c)) continue;
    if (x > width_) return;
    const bool known = c >= kFirstLetter && c <= kLastLetter;
    const auto index = static_cast<std::size_t>((known ? c : '?') - kFirstLetter);
    const double whole = std::floor(x);
    const auto phase = static_cast<std::size_t>((x - whole) * kPhases);
    const Glyph& glyph = letters.glyph(index, phase, cell);
    const int left = static_cast<int>(whole) - kGlyphMargin;
    for (int gy = std::max(-top, 0); gy < std::min(glyph.height, height_ - top); ++gy) {
      Rgba* const pixels = row(top + gy);
      const std::uint8_t* const cover = glyph.cover.data() + gy * glyph.width;
      for (int gx = std::max(-left, 0); gx < std::min(glyph.width, width_ - left); ++gx) {
        if (cover[gx] > 0) blend(pixels[left + gx], withAlpha(color, cover[gx]));
      }
    }
    x += letters.advance[index];
  }
}

void HudPaint::image(const PixelRect& rect, const Image& image) {
  if (image.pixels.empty()) return;
  const PixelRect part = inside(rect);
  std::vector<int> columns(static_cast<std::size_t>(part.width));
  for (int x = 0; x < part.width; ++x) {
    columns[static_cast<std::size_t>(x)] = nearestPixel(part.left + x - rect.left, image.width, rect.width);
  }
  for (int y = 0; y < part.height; ++y) {
    Rgba* const to = row(part.top + y) + part.left;
    const Rgb* const from = &image.at(0, nearestPixel(part.top + y - rect.top, image.height, rect.height));
    for (int x = 0; x < part.width; ++x) to[x] = opaque(from[columns[static_cast<std::size_t>(x)]]);
  }
}

template <class DepthAt>
void HudPaint::shape(const PixelRect& rect, const Rgb& color, const DepthAt& depthAt) {
  const PixelRect part = inside(rect);
  for (int y = part.top; y < part.top + part.height; ++y) {
    for (int x = part.left; x < part.left + part.width; ++x) {
      blend(row(y)[x], covered(color, depthAt(x + 0.5, y + 0.5) + 0.5));
    }
  }
}

void HudPaint::disc(double x, double y, double radius, const Rgb& color) {
  ring(x, y, radius / 2, radius, color);
}

void HudPaint::ring(double x, double y, double radius, double thickness, const Rgb& color) {
  const double reach = radius + thickness / 2 + 1;
  if (!(std::abs(x) < 1e6) || !(std::abs(y) < 1e6)) return;
  const PixelRect around{static_cast<int>(std::floor(x - reach)), static_cast<int>(std::floor(y - reach)),
                         static_cast<int>(2 * reach) + 2, static_cast<int>(2 * reach) + 2};
  shape(around, color,
        [&](double px, double py) { return thickness / 2 - std::abs(std::hypot(px - x, py - y) - radius); });
}

void HudPaint::arrow(const PixelRect& rect, const Rgb& color) {
  const double slope = 0.5 * rect.height / std::max(rect.width, 1);
  const double middle = rect.top + 0.5 * rect.height;
  shape(rect, color, [&](double px, double py) {
    const double half = (rect.left + rect.width - px) * slope;
    return std::min((half - std::abs(py - middle)) / std::hypot(1.0, slope), px - rect.left);
  });
}

std::string fittedText(std::string_view text, double width, double cell) {
  width += 0.5;  // what was measured fits, however it was rounded
  if (text.empty() || width <= 0) return {};
  const std::size_t bytes = fittingBytes(text, width, cell);
  if (bytes == text.size()) return fitText(text, width, cell);
  // What is left out makes room for dots.
  return fitText(std::string(text.substr(0, bytes)) + "...", width, cell);
}

std::string fittedTail(std::string_view text, double width, double cell) {
  if (textWidth(text, cell) <= width) return std::string(text);
  std::size_t first = text.size();
  double used = textWidth("...", cell);
  while (first > 0) {
    std::size_t next = first - 1;
    while (next > 0 && continuesLetter(text[next])) --next;
    used += textWidth(text.substr(next, first - next), cell) + cell;
    if (used > width) break;
    first = next;
  }
  return "..." + std::string(text.substr(first));
}

std::vector<std::string> wrappedText(std::string_view text, double width, double cell, std::size_t most) {
  std::vector<std::string> lines;
  std::string line;
  const auto push = [&] { lines.push_back(std::exchange(line, {})); };
  const auto addWord = [&](std::string_view word) {
    if (!line.empty() && textWidth(line, cell) + textWidth(word, cell) + 4 * cell > width) push();
    if (!line.empty()) line += ' ';
    while (lines.size() <= most && !word.empty()) {
      const std::size_t bytes = line.empty() ? fittingBytes(word, width, cell) : word.size();
      line += word.substr(0, bytes);
      word.remove_prefix(bytes);
      if (!word.empty()) push();
    }
  };
  while (!text.empty() && lines.size() <= most) {
    const std::size_t end = std::min(text.find_first_of(" \n"), text.size());
    addWord(text.substr(0, end));
    if (end < text.size() && text[end] == '\n') push();
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (!line.empty()) push();
  if (lines.size() > most) {
    lines.resize(most);
    if (most > 0) {
      const std::string cut = lines.back() + " ...";
      lines.back() = textWidth(cut, cell) <= width ? cut : fittedText(cut + "...", width, cell);
    }
  }
  return lines;
}

}  // namespace scanmill
