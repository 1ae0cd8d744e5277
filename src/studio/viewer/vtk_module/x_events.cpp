#include "viewer/vtk_module/x_events.h"

#include <X11/Xutil.h>
#include <X11/keysym.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace scanmill {

namespace {

constexpr Time kDoubleClick = 400;  // ms
constexpr int kSamePlace = 4;       // px

}  // namespace

XEvents::XEvents(Display* display, Window window, int width, int height)
    : display_(display),
      window_(window),
      protocols_(XInternAtom(display, "WM_PROTOCOLS", False)),
      deleteWindow_(XInternAtom(display, "WM_DELETE_WINDOW", False)),
      width_(width),
      height_(height) {
  XSetWMProtocols(display, window, &deleteWindow_, 1);
  // The input method is that of Xlib itself, not of an input server, which could be gone. It knows all keyboards and
  // dead keys.
  XSetLocaleModifiers("@im=none");
  method_ = XOpenIM(display, nullptr, nullptr, nullptr);
  if (method_ != nullptr) {
    context_ = XCreateIC(method_, XNInputStyle, XIMPreeditNothing | XIMStatusNothing, XNClientWindow, window, nullptr);
  }
  XSelectInput(display, window,
               KeyPressMask | ButtonPressMask | ButtonReleaseMask | PointerMotionMask | ExposureMask |
                   StructureNotifyMask | FocusChangeMask);
}

XEvents::~XEvents() {
  if (context_ != nullptr) XDestroyIC(context_);
  if (method_ != nullptr) XCloseIM(method_);
}

CanvasEvent XEvents::plain(CanvasEvent::Kind kind) const {
  CanvasEvent event;
  event.kind = kind;
  event.x = x_;
  event.y = y_;
  event.width = width_;
  event.height = height_;
  return event;
}

CanvasEvent XEvents::at(CanvasEvent::Kind kind, int x, int y, unsigned modifiers) {
  x_ = x;
  y_ = y;
  CanvasEvent event = plain(kind);
  event.shift = (modifiers & ShiftMask) != 0;
  event.control = (modifiers & ControlMask) != 0;
  return event;
}

std::optional<CanvasEvent> XEvents::configured(int width, int height) {
  if (width_ == width && height_ == height) return {};
  width_ = width;
  height_ = height;
  return plain(CanvasEvent::Kind::Resize);
}

CanvasEvent XEvents::size() {
  XWindowAttributes attributes{};
  if (XGetWindowAttributes(display_, window_, &attributes) != 0) configured(attributes.width, attributes.height);
  return plain(CanvasEvent::Kind::Resize);
}

CanvasEvent XEvents::key(XKeyEvent& press) {
  CanvasEvent event = at(CanvasEvent::Kind::Key, press.x, press.y, press.state);
  std::array<char, 64> typed{};
  KeySym symbol = NoSymbol;
  int length = 0;
  if (context_ != nullptr) {
    int status = 0;
    length = Xutf8LookupString(context_, &press, typed.data(), static_cast<int>(typed.size()), &symbol, &status);
    if (status == XBufferOverflow) length = 0;
    if (status == XLookupChars) symbol = XLookupKeysym(&press, 0);
  } else {
    length = XLookupString(&press, typed.data(), static_cast<int>(typed.size()), &symbol, nullptr);
    if (length == 1 && static_cast<unsigned char>(typed[0]) >= 0x80) length = 0;  // Latin-1
  }
  const char* name = symbol != NoSymbol ? XKeysymToString(symbol) : nullptr;
  event.key = name != nullptr ? name : "";
  const std::string_view text(typed.data(), static_cast<std::size_t>(std::max(length, 0)));
  const bool controls = !text.empty() && (static_cast<unsigned char>(text[0]) < 0x20 || text[0] == 0x7F);
  if (!controls) event.text = text;
  return event;
}

std::optional<CanvasEvent> XEvents::button(const XButtonEvent& press, bool down) {
  if (press.button >= 4) {  // 4 and 5 are the wheel's, 6 and 7 of one that tilts
    if (!down || press.button > 5) return {};
    CanvasEvent event = at(CanvasEvent::Kind::Wheel, press.x, press.y, press.state);
    event.amount = press.button == 4 ? 1 : -1;
    return event;
  }
  CanvasEvent event = at(down ? CanvasEvent::Kind::Down : CanvasEvent::Kind::Up, press.x, press.y, press.state);
  event.button = static_cast<int>(press.button);
  if (down) {
    const bool again = clicks_ == 1 && press.button == lastPress_.button &&
                       press.time - lastPress_.time <= kDoubleClick && std::abs(press.x - lastPress_.x) <= kSamePlace &&
                       std::abs(press.y - lastPress_.y) <= kSamePlace;
    clicks_ = again ? 2 : 1;
    lastPress_ = press;
  }
  event.clicks = std::max(clicks_, 1);
  return event;
}

std::optional<CanvasEvent> XEvents::take() {
  XEvent event{};
  XNextEvent(display_, &event);
  if (XFilterEvent(&event, None) != 0) return {};
  if (event.type == MappingNotify) {
    XRefreshKeyboardMapping(&event.xmapping);
    return {};
  }
  if (event.xany.window != window_) return {};
  const auto skipTo = [&] {
    XEvent next{};
    while (XEventsQueued(display_, QueuedAfterReading) > 0) {
      XPeekEvent(display_, &next);
      if (next.type != event.type || next.xany.window != window_) return;
      XNextEvent(display_, &event);
    }
  };
  switch (event.type) {
    case KeyPress:
      return key(event.xkey);
    case ButtonPress:
    case ButtonRelease:
      return button(event.xbutton, event.type == ButtonPress);
    case MotionNotify:
      skipTo();
      return at(CanvasEvent::Kind::Move, event.xmotion.x, event.xmotion.y, event.xmotion.state);
    case ConfigureNotify:
      skipTo();
      return configured(event.xconfigure.width, event.xconfigure.height);
    case Expose:
      if (event.xexpose.count > 0) return {};
      return plain(CanvasEvent::Kind::Redraw);
    case FocusIn:
      if (context_ != nullptr) XSetICFocus(context_);
      return {};
    case FocusOut:
      if (context_ != nullptr) XUnsetICFocus(context_);
      return {};
    case ClientMessage:
      if (event.xclient.message_type == protocols_ && static_cast<Atom>(event.xclient.data.l[0]) == deleteWindow_) {
        return plain(CanvasEvent::Kind::Close);
      }
      return {};
    case DestroyNotify:
      return plain(CanvasEvent::Kind::Close);
    default:
      return {};
  }
}

}  // namespace scanmill
