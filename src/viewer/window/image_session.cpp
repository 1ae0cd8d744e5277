#include "viewer/window/image_session.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/wall_timer.h"
#include "viewer/color_map.h"
#include "viewer/pass_picture.h"
#include "viewer/window/hud.h"
#include "viewer/window/save_picture.h"

namespace scanmill {

namespace {

std::vector<std::pair<std::string, std::string>> imageKeys() {
  return {{"Right, Left (] [)", "next, previous plane"},
          {"wheel", "larger, smaller"},
          {"drag", "move"},
          {"Home", "the whole image"},
          {"P", "save a picture"},
          {"h", "these keys"},
          {"q, Escape", "quit"}};
}

// The part of a plane that is seen, in its pixels.
struct Window {
  int left = 0, top = 0, width = 1, height = 1;
};

Image crop(const Image& image, const Window& part) {
  Image out(part.width, part.height, {});
  paste(out, image, -part.left, -part.top);
  return out;
}

}  // namespace

struct ImageSession::State {
  State(const std::filesystem::path& exr, const Ontology* ontology, Canvas& drawnOn, const std::string& wanted,
        bool bare)
      : file(exr), canvas(drawnOn), planes(readExrPlanes(exr, ontology)) {
    hud.bare = bare;
    hud.title = file.filename().string();
    if (wanted.empty()) return;
    std::vector<std::string> names;
    for (const PassPlane& p : planes) names.push_back(p.name);
    const auto found = std::find(names.begin(), names.end(), wanted);
    if (found == names.end()) {
      throw InputError({file.string()}, fmt::format("has no plane '{}'; it has {}", wanted, fmt::join(names, ", ")));
    }
    plane = static_cast<std::size_t>(found - names.begin());
  }

  const Image& image() const { return planes[plane].image; }

  void step(int by) {
    const std::size_t count = planes.size();
    plane = (plane + (by > 0 ? 1 : count - 1)) % count;
    pictureChanged = true;
  }

  void scale(double by) {
    const double most = std::max(1.0, std::min(image().width, image().height) / 4.0);
    zoom = std::clamp(zoom * by, 1.0, most);
    pictureChanged = true;
  }

  void show() {
    if (pictureChanged) {
      const Image& whole = image();
      part.width = std::clamp(static_cast<int>(std::lround(whole.width / zoom)), 1, whole.width);
      part.height = std::clamp(static_cast<int>(std::lround(whole.height / zoom)), 1, whole.height);
      centerX = std::clamp(centerX, 0.5 * part.width / whole.width, 1 - 0.5 * part.width / whole.width);
      centerY = std::clamp(centerY, 0.5 * part.height / whole.height, 1 - 0.5 * part.height / whole.height);
      part.left = std::clamp(static_cast<int>(std::lround(centerX * whole.width - part.width / 2.0)), 0,
                             whole.width - part.width);
      part.top = std::clamp(static_cast<int>(std::lround(centerY * whole.height - part.height / 2.0)), 0,
                            whole.height - part.height);
      const PassPlane& p = planes[plane];
      hud.picture = HudStrip{zoom > 1 ? crop(whole, part) : whole, {}, p.note};
      hud.summary = fmt::format("{} ({} of {}), {} x {}", p.name, plane + 1, planes.size(), whole.width, whole.height);
      pictureChanged = false;
    }
    hud.width = canvas.width();
    hud.height = canvas.height();
    hud.help = help;
    hud.keys = help ? imageKeys() : std::vector<std::pair<std::string, std::string>>{};
    layout = layoutHud(hud);
    point();
    drawn = drawHud(hud);
    CanvasView view;
    view.rect = {0, 0, hud.width, hud.height};
    view.background = kBackground;
    canvas.setViews({&view, 1});
    canvas.setOverlay(hud.width, hud.height, drawn.pixels);
    canvas.render();
    changed = false;
  }

  // Column and row of the whole image.
  std::optional<std::pair<int, int>> pixelAt(int x, int y) const {
    if (!hud.picture) return {};
    auto pixel = imagePixelAt(layout.picture, hud.picture->image, x, y);
    if (pixel) *pixel = {pixel->first + part.left, pixel->second + part.top};
    return pixel;
  }

  std::optional<std::vector<std::pair<std::string, std::string>>> valuesAt(int x, int y) const {
    const auto pixel = pixelAt(x, y);
    if (!pixel) return {};
    std::vector<std::pair<std::string, std::string>> rows;
    rows.emplace_back("pixel", fmt::format("{}, {}", pixel->first, pixel->second));
    for (const PassPlane& p : planes) {
      const std::string text = p.value(pixel->first, pixel->second);
      const std::size_t colon = text.find(": ");
      if (colon == std::string::npos) {
        rows.emplace_back(p.name, text);
      } else {
        rows.emplace_back(text.substr(0, colon), text.substr(colon + 2));
      }
    }
    return rows;
  }

  void point() {
    hud.tip.reset();
    hud.picture->mark.reset();
    const auto pixel = pixelAt(pointerX, pointerY);
    if (!pixel) return;
    hud.picture->mark = {pixel->first - part.left, pixel->second - part.top};
    HudTip tip;
    tip.x = pointerX;
    tip.y = pointerY;
    tip.heading = planes[plane].name;
    tip.color = image().at(pixel->first, pixel->second);
    tip.rows = *valuesAt(pointerX, pointerY);
    hud.tip = std::move(tip);
  }

  void notice(const std::string& text) {
    constexpr double kSeconds = 4;
    hud.notices = {text};
    noticeUntil = clock.seconds() + kSeconds;
  }

  bool key(const std::string& name) {
    changed = true;
    if (name == "Right" || name == "bracketright" || name == "KP_Right" || name == "period") {
      step(1);
    } else if (name == "Left" || name == "bracketleft" || name == "KP_Left" || name == "comma") {
      step(-1);
    } else if (name == "Home") {
      zoom = 1;
      pictureChanged = true;
    } else if (name == "h" || name == "question") {
      help = !help;
    } else if (name == "Escape" && help) {
      help = false;
    } else if (name == "q" || name == "Escape") {
      return false;
    } else if (name == "P") {
      show();
      try {
        notice("saved " + saveViewPicture(canvas.read()));
      } catch (const Error& e) {
        notice(e.what());
      }
    }
    return true;
  }

  void move(const CanvasEvent& event) {
    if (dragging && layout.picture.width > 0 && layout.picture.height > 0) {
      centerX -= (event.x - pointerX) / (layout.picture.width * zoom);
      centerY -= (event.y - pointerY) / (layout.picture.height * zoom);
      pictureChanged = true;
    }
    pointerX = event.x;
    pointerY = event.y;
    changed = true;
  }

  std::filesystem::path file;
  Canvas& canvas;
  std::vector<PassPlane> planes;
  std::size_t plane = 0;
  double zoom = 1;
  double centerX = 0.5, centerY = 0.5;  // of what is seen, 0 to 1
  Window part;
  HudState hud;
  HudLayout layout;
  Hud drawn;
  bool help = false;
  bool dragging = false;
  bool changed = true;
  bool pictureChanged = true;
  int pointerX = -1, pointerY = -1;
  WallTimer clock;
  double noticeUntil = 0;  // s
};

ImageSession::ImageSession(const std::filesystem::path& file, const Ontology* ontology, Canvas& canvas,
                           const std::string& plane, bool bare)
    : state_(std::make_unique<State>(file, ontology, canvas, plane, bare)) {}

ImageSession::~ImageSession() = default;

bool ImageSession::handle(const CanvasEvent& event) {
  constexpr double kStep = 1.25;
  State& s = *state_;
  switch (event.kind) {
    case CanvasEvent::Kind::Close:
      return false;
    case CanvasEvent::Kind::Key:
      if (!s.key(event.key)) return false;
      break;
    case CanvasEvent::Kind::Move:
      s.move(event);
      break;
    case CanvasEvent::Kind::Down:
      s.dragging = s.layout.picture.contains(event.x, event.y);
      break;
    case CanvasEvent::Kind::Up:
      s.dragging = false;
      break;
    case CanvasEvent::Kind::Wheel:
      if (std::isfinite(event.amount)) s.scale(std::pow(kStep, std::clamp(event.amount, -20.0, 20.0)));
      s.changed = true;
      break;
    case CanvasEvent::Kind::Resize:
    case CanvasEvent::Kind::Expose:
      s.changed = true;
      break;
    case CanvasEvent::Kind::Tick:
      if (!s.hud.notices.empty() && s.clock.seconds() > s.noticeUntil) {
        s.hud.notices.clear();
        s.changed = true;
      }
      break;
  }
  // Moves come in crowds: they are drawn with the next tick.
  if (s.changed && event.kind != CanvasEvent::Kind::Move) s.show();
  return true;
}

void ImageSession::settle() {
  state_->hud.notices.clear();
  state_->show();
}

Image ImageSession::picture() {
  return state_->canvas.read();
}

std::optional<std::vector<std::pair<std::string, std::string>>> ImageSession::pick(int x, int y) const {
  return state_->valuesAt(x, y);
}

}  // namespace scanmill
