#include "viewer/window/image_session.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/wall_timer.h"
#include "viewer/color_map.h"
#include "viewer/panels/parts.h"
#include "viewer/panels/rooms.h"
#include "viewer/panels/toolkit.h"
#include "viewer/pass_picture.h"
#include "viewer/window/image_pane.h"

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
          {"h", "these keys"},
          {"Escape", "close what is open"},
          {"q", "quit"}};
}

bool isAmong(const std::string& name, std::initializer_list<const char*> names) {
  return std::ranges::any_of(names, [&](const char* n) { return name == n; });
}

constexpr ImageId kImage = 2;

}  // namespace

struct ImageSession::State {
  State(ImageList all, Canvas& drawnOn, const std::string& wanted, bool bareOne, bool stillOne)
      : images(std::move(all)),
        canvas(drawnOn),
        toolkit(drawnOn, letterOf(drawnOn, stillOne)),
        bare(bareOne),
        still(stillOne),
        index(images.first) {
    load();
    if (wanted.empty()) return;
    std::vector<std::string> names;
    for (const PassPlane& p : planes) names.push_back(p.name);
    const auto found = std::ranges::find(names, wanted);
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

  // Shows another image; if it cannot be read, only the reason is shown.
  void goTo(std::size_t target) {
    target = std::min(target, images.files.size() - 1);
    if (target == index) return;
    const std::string name = planes[plane].name;
    index = target;
    problems.clear();
    try {
      load();
    } catch (const Error& e) {
      problems = {e.what()};
      warn(e.what());
      planes = {PassPlane{name, Image(1, 1, kBackground), [](int, int) { return std::string(); }, "", {}}};
    }
    const auto same = std::ranges::find_if(planes, [&](const PassPlane& p) { return p.name == name; });
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
    playing = !playing;
    lastStep = clock.seconds();
    if (playing && index + 1 == images.files.size()) goTo(0);
  }

  // Enlarges the image around the pixel (x, y) of the canvas. `steps`: steps of the wheel; negative: makes it smaller.
  void zoom(double steps, int x, int y) {
    constexpr double kStep = 1.25;
    pane.zoomAt(std::pow(kStep, std::clamp(steps, -20.0, 20.0)), x, y);
    changed = true;
  }

  void show() {
    const PassPlane& p = planes[plane];
    const PanelNeeds needs{.letter = toolkit.letter(),
                           .row = toolkit.row(),
                           .title = !bare,
                           .side = !bare && legends && (p.legend.scale || !p.legend.entries.empty()),
                           .bar = !bare && !still};
    rooms = roomsOf(canvas.width(), canvas.height(), needs);
    note = {rooms.body.left, rooms.body.top, rooms.body.width, 0};
    if (!bare && !p.note.empty()) {
      note.height = std::min(static_cast<int>(std::lround(1.5 * toolkit.letter())), rooms.body.height / 3);
    }
    rooms.body.top += note.height;
    rooms.body.height -= note.height;
    pane.place(p.image.width, p.image.height, rooms.body);
    if (pictureChanged) setImage(canvas, kImage, p.image);
    pictureChanged = false;
    CanvasView view{.rect = {0, 0, canvas.width(), canvas.height()}, .background = kBackground};
    canvas.setViews({&view, 1});
    runPanels();
    runPanels();  // sizes that depend on contents are known only in the second run
    canvas.render();
    changed = false;
  }

  void runPanels() {
    toolkit.frame([&] { drawPanels(); });
  }

  void drawPanels() {
    const PassPlane& p = planes[plane];
    const bool several = images.files.size() > 1;
    if (!bare) {
      titleRow(rooms.title, several ? images.title + ": " + images.names[index] : images.title,
               fmt::format("{} ({} of {}), {} x {}", p.name, plane + 1, planes.size(), p.image.width, p.image.height));
    }
    std::optional<std::pair<double, double>> mark;
    Rgb under{};
    if (const auto pixel = pane.pixelAt(pointerX, pointerY); pixel && overImage && !help) {
      under = image().at(pixel->first, pixel->second);
      mark = pane.placeOf(pixel->first, pixel->second);
    }
    panelAt("##note", note, false, [&] {
      const double letter = toolkit.letter();
      wordsAt(note.left + letter / 2, note.top + letter / 4, note.width - letter, p.note, true);
    });
    panelAt("##image", rooms.body, false,
            [&] { overImage = imageAt(kImage, pane.rect(), bare ? std::nullopt : mark); });
    if (bare) return;
    panelAt("##side", rooms.side, !still, [&] { legendSection(p.legend, still); });
    if (mark) tip(p.name, under, *valuesAt(pointerX, pointerY));
    if (still) return;
    const FrameBarUse use = frameBar(
        rooms.bar, {.frame = index, .frames = images.files.size(), .key = images.names[index], .playing = playing});
    if (use.play) togglePlaying();
    if (use.frame) {
      playing = false;
      goTo(*use.frame);
    }
    if (messages(rooms.body, problems, notices)) problems.clear();
    if (help && !helpWindow(imageKeys())) help = false;
  }

  std::optional<std::vector<std::pair<std::string, std::string>>> valuesAt(int x, int y) const {
    const auto pixel = pane.pixelAt(x, y);
    if (!pixel) return {};
    std::vector<std::pair<std::string, std::string>> rows;
    rows.emplace_back("pixel", fmt::format("{}, {}", pixel->first, pixel->second));
    for (const PassPlane& p : planes) rows.emplace_back(p.name, p.value(pixel->first, pixel->second));
    return rows;
  }

  void notice(const std::string& text) {
    constexpr double kSeconds = 4;
    notices = {text};
    noticeUntil = clock.seconds() + kSeconds;
    changed = true;
  }

  bool key(const std::string& name) {
    changed = true;
    if (isAmong(name, {"Right", "]"})) {
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
    } else if (name == "Escape") {
      if (!help) notice("q quits");
      help = false;
    } else if (name == "q") {
      return false;
    } else if (name == "P") {
      show();
      try {
        notice("saved " + savePictureOf(canvas).string());
      } catch (const Error& e) {
        notice(e.what());
      }
    }
    return true;
  }

  void move(const CanvasEvent& event) {
    if (dragging) pane.moveBy(event.x - pointerX, event.y - pointerY);
    pointerX = event.x;
    pointerY = event.y;
    changed = true;
  }

  void tick() {
    constexpr double kImageSeconds = 0.5;
    const double now = clock.seconds();
    if (!notices.empty() && now > noticeUntil) {
      notices.clear();
      changed = true;
    }
    if (!playing || now - lastStep < kImageSeconds) return;
    goTo(index + 1);
    playing = index + 1 < images.files.size();
    changed = true;
  }

  ImageList images;
  Canvas& canvas;
  Toolkit toolkit;
  bool bare;
  bool still;
  std::size_t index = 0;
  std::vector<PassPlane> planes;
  std::size_t plane = 0;
  ImagePane pane;
  PanelRooms rooms;
  PixelRect note;  // rectangle of the text above the image, PassPlane::note
  std::vector<std::string> problems, notices;
  bool playing = false;
  bool legends = true;
  bool help = false;
  bool overImage = false;
  bool dragging = false;
  bool changed = true;
  bool pictureChanged = true;
  int pointerX = -1, pointerY = -1;
  WallTimer clock;
  double noticeUntil = 0;  // time until which notices are shown (s)
  double lastStep = 0;     // time of the last change of the image, or of the start of playing (s)
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
      s.toolkit.take(event);
      s.move(event);
      break;
    case CanvasEvent::Kind::Down:
    case CanvasEvent::Kind::Up:
    case CanvasEvent::Kind::Wheel:
      s.toolkit.take(event);
      s.runPanels();
      s.dragging = event.kind == CanvasEvent::Kind::Down && s.overImage && !s.help;
      s.changed = true;
      if (event.kind == CanvasEvent::Kind::Wheel && s.overImage && !s.help && std::isfinite(event.amount)) {
        s.zoom(event.amount, event.x, event.y);
      }
      break;
    case CanvasEvent::Kind::Resize:
    case CanvasEvent::Kind::Redraw:
      s.changed = true;
      break;
    case CanvasEvent::Kind::Tick:
      s.tick();
      break;
  }
  // Moves are frequent, so their effects are drawn only at the next tick.
  if (s.changed && event.kind != CanvasEvent::Kind::Move) s.show();
  return true;
}

void ImageSession::settle() {
  state_->notices.clear();
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
