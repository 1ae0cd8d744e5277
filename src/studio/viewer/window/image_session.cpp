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
#include "viewer/window/hud_parts.h"
#include "viewer/window/image_pane.h"
#include "viewer/window/save_picture.h"

namespace scanmill {

namespace {

std::vector<std::pair<std::string, std::string>> imageKeys() {
  return {{"Right, Left (] [)", "next, previous plane"},
          {"Page_Down, Page_Up (. ,)", "next, previous image"},
          {"< >", "first, last image"},
          {"space", "play, pause"},
          {"wheel", "larger, smaller"},
          {"drag", "move"},
          {"Home", "the whole image"},
          {"k", "legend (what colours mean)"},
          {"P", "save a picture"},
          {"h", "these keys; Up, Down or the wheel: more of them"},
          {"Escape", "close what is open"},
          {"q", "quit"}};
}

bool isAmong(const std::string& name, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
}

}  // namespace

struct ImageSession::State {
  State(ImageList all, Canvas& drawnOn, const std::string& wanted, bool bare, bool still)
      : images(std::move(all)), canvas(drawnOn), index(images.first) {
    hud.bare = bare;
    hud.still = still;
    hud.frames = images.files.size();
    load();
    if (wanted.empty()) return;
    std::vector<std::string> names;
    for (const PassPlane& p : planes) names.push_back(p.name);
    const auto found = std::find(names.begin(), names.end(), wanted);
    if (found == names.end()) {
      throw InputError({images.files[index].string()},
                       fmt::format("has no plane '{}'; it has {}", wanted, fmt::join(names, ", ")));
    }
    plane = static_cast<std::size_t>(found - names.begin());
  }

  const Image& image() const { return planes[plane].image; }

  void load() {
    planes = readExrPlanes(images.files[index], images.ontology ? &*images.ontology : nullptr, images.materials(index));
  }

  // Of images that cannot be read, nothing is shown but why.
  void goTo(std::size_t target) {
    target = std::min(target, images.files.size() - 1);
    if (target == index) return;
    const std::string name = planes[plane].name;
    index = target;
    hud.problems.clear();
    try {
      load();
    } catch (const Error& e) {
      hud.problems = {e.what()};
      warn(e.what());
      planes = {PassPlane{name, Image(1, 1, kBackground), [](int, int) { return std::string(); }, "", {}}};
    }
    const auto same = std::find_if(planes.begin(), planes.end(), [&](const PassPlane& p) { return p.name == name; });
    plane = same == planes.end() ? 0 : static_cast<std::size_t>(same - planes.begin());
    lastStep = clock.seconds();
    changed = pictureChanged = true;
  }

  void stepImage(int by) {
    const std::size_t count = images.files.size();
    if (count == 1) return notice("there is one image only: the recording's folder shows all");
    const bool ends = by > 0 ? index + 1 == count : index == 0;
    if (ends) return notice(by > 0 ? "this is the last image" : "this is the first image");
    goTo(by > 0 ? index + 1 : index - 1);
  }

  void stepPlane(int by) {
    const std::size_t count = planes.size();
    plane = (plane + (by > 0 ? 1 : count - 1)) % count;
    pictureChanged = true;
  }

  void togglePlaying() {
    if (images.files.size() == 1) return notice("there is one image only");
    hud.playing = !hud.playing;
    lastStep = clock.seconds();
    if (hud.playing && index + 1 == images.files.size()) goTo(0);
  }

  // Pixel of what is drawn of the image, of which there is one per pixel of the canvas.
  std::optional<std::pair<double, double>> roomAt(int x, int y) const {
    if (!hud.picture) return {};
    const auto pixel = imagePixelAt(layout.picture, hud.picture->image, x, y);
    if (!pixel) return {};
    return std::pair(pixel->first + 0.5, pixel->second + 0.5);
  }

  void zoom(double steps, int x, int y) {
    constexpr double kStep = 1.25;
    const auto at = roomAt(x, y);
    const double middleX = hud.picture ? hud.picture->image.width / 2.0 : 0;
    const double middleY = hud.picture ? hud.picture->image.height / 2.0 : 0;
    pane.zoomAt(std::pow(kStep, std::clamp(steps, -20.0, 20.0)), at ? at->first : middleX, at ? at->second : middleY);
    pictureChanged = true;
  }

  void show() {
    const PassPlane& p = planes[plane];
    hud.title = images.files.size() > 1 ? images.title + ": " + images.names[index] : images.title;
    hud.key = images.names[index];
    hud.frame = images.files.size() > 1 ? std::optional(index) : std::nullopt;
    hud.summary =
        fmt::format("{} ({} of {}), {} x {}", p.name, plane + 1, planes.size(), p.image.width, p.image.height);
    hud.panes.clear();
    if (legends && (p.legend.scale || !p.legend.entries.empty())) hud.panes.emplace_back().legend = p.legend;
    if (hud.width != canvas.width() || hud.height != canvas.height()) pictureChanged = true;
    hud.width = canvas.width();
    hud.height = canvas.height();
    hud.help = help;
    hud.keys = help ? imageKeys() : std::vector<std::pair<std::string, std::string>>{};
    if (pictureChanged) {
      if (!hud.picture) hud.picture.emplace();
      const HudFrame frame = frameOf(hud);
      pane.place(p.image.width, p.image.height, frame.body.width, frame.body.height - frame.pictureCaption.height);
      hud.picture = HudStrip{pane.draw(p.image), {}, p.note};
      pictureChanged = false;
    }
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

  std::optional<std::pair<int, int>> pixelAt(int x, int y) const {
    const auto at = roomAt(x, y);
    return at ? pane.pixelAt(at->first, at->second) : std::nullopt;
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
    if (!pixel || help) return;
    const HudRegion* const over = regionAt(drawn, pointerX, pointerY);
    if (over != nullptr && over->part != HudPart::Picture) return;
    hud.picture->mark = pane.roomPixelOf(pixel->first, pixel->second);
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
    changed = true;
  }

  void scrollHelp(double lines) {
    const auto last = static_cast<double>(helpPages(hud).lastFirst);
    hud.helpFirst =
        static_cast<std::size_t>(std::clamp(static_cast<double>(hud.helpFirst) + std::round(lines), 0.0, last));
    changed = true;
  }

  bool key(const std::string& name) {
    changed = true;
    if (help && isAmong(name, {"Up", "Down"})) {
      const auto page = static_cast<double>(helpPages(hud).page);
      scrollHelp(name.ends_with("Up") ? -page : page);
    } else if (isAmong(name, {"Right", "]"})) {
      stepPlane(1);
    } else if (isAmong(name, {"Left", "["})) {
      stepPlane(-1);
    } else if (isAmong(name, {"Page_Down", "."})) {
      stepImage(1);
    } else if (isAmong(name, {"Page_Up", ","})) {
      stepImage(-1);
    } else if (name == "<") {
      goTo(0);
    } else if (isAmong(name, {">", "End"})) {
      goTo(images.files.size() - 1);
    } else if (name == " ") {
      togglePlaying();
    } else if (name == "Home") {
      pane.showWhole();
      pictureChanged = true;
    } else if (name == "k") {
      legends = !legends;
    } else if (isAmong(name, {"h", "?"})) {
      help = !help;
      hud.helpFirst = 0;
    } else if (name == "Escape") {
      if (!help) notice("q quits");
      help = false;
    } else if (name == "q") {
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

  void press(const CanvasEvent& event) {
    dragging = sliding = false;
    const HudRegion* const over = regionAt(drawn, event.x, event.y);
    if (over == nullptr) return;
    switch (over->part) {
      case HudPart::Picture:
        dragging = true;
        break;
      case HudPart::Slider:
        sliding = true;
        slider = over->rect;
        hud.playing = false;
        goTo(sliderFrame(slider, images.files.size(), event.x));
        break;
      case HudPart::PlayButton:
        togglePlaying();
        break;
      case HudPart::Help:
        help = !help;
        hud.helpFirst = 0;
        break;
      case HudPart::Problem:
        hud.problems.clear();
        break;
      default:
        break;
    }
    changed = true;
  }

  void move(const CanvasEvent& event) {
    if (sliding) goTo(sliderFrame(slider, images.files.size(), event.x));
    if (dragging) {
      pane.moveBy(event.x - pointerX, event.y - pointerY);
      pictureChanged = true;
    }
    pointerX = event.x;
    pointerY = event.y;
    changed = true;
  }

  void tick() {
    constexpr double kImageSeconds = 0.5;
    const double now = clock.seconds();
    if (!hud.notices.empty() && now > noticeUntil) {
      hud.notices.clear();
      changed = true;
    }
    if (!hud.playing || now - lastStep < kImageSeconds) return;
    goTo(index + 1);
    hud.playing = index + 1 < images.files.size();
    changed = true;
  }

  ImageList images;
  Canvas& canvas;
  std::size_t index = 0;
  std::vector<PassPlane> planes;
  std::size_t plane = 0;
  ImagePane pane;
  HudState hud;
  HudLayout layout;
  Hud drawn;
  bool legends = true;
  bool help = false;
  bool dragging = false;
  bool sliding = false;
  PixelRect slider;
  bool changed = true;
  bool pictureChanged = true;
  int pointerX = -1, pointerY = -1;
  WallTimer clock;
  double noticeUntil = 0;  // s
  double lastStep = 0;     // s, of playing
};

ImageSession::ImageSession(ImageList images, Canvas& canvas, const std::string& plane, bool bare, bool still)
    : state_(std::make_unique<State>(std::move(images), canvas, plane, bare, still)) {}

ImageSession::~ImageSession() = default;

bool ImageSession::handle(const CanvasEvent& event) {
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
      s.press(event);
      break;
    case CanvasEvent::Kind::Up:
      s.dragging = s.sliding = false;
      break;
    case CanvasEvent::Kind::Wheel:
      if (!std::isfinite(event.amount)) break;
      s.changed = true;
      s.help ? s.scrollHelp(-3 * event.amount) : s.zoom(event.amount, event.x, event.y);
      break;
    case CanvasEvent::Kind::Resize:
    case CanvasEvent::Kind::Redraw:
      s.changed = true;
      break;
    case CanvasEvent::Kind::Tick:
      s.tick();
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

const std::string& ImageSession::name() const {
  return state_->images.names[state_->index];
}

std::optional<std::vector<std::pair<std::string, std::string>>> ImageSession::pick(int x, int y) const {
  return state_->valuesAt(x, y);
}

}  // namespace scanmill
