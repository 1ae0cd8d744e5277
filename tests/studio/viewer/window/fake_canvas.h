#pragma once

// A canvas in memory: remembers what it was given and draws the overlay alone, the same on every machine.

#include <array>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "viewer/canvas/canvas.h"

namespace scanmill {

class FakeCanvas : public Canvas {
 public:
  struct Item {
    ItemKind kind = ItemKind::Points;
    std::vector<Vec3f> places;
    std::vector<Rgb> colors;
    std::optional<std::vector<std::uint32_t>> shown;  // none: all
    ItemLook look;
  };

  FakeCanvas(int width, int height) : width_(width), height_(height) {}

  int width() const override { return width_; }
  int height() const override { return height_; }
  double scale() const override { return 1; }
  void resize(int width, int height) {
    width_ = width;
    height_ = height;
    painted_.clear();
  }
  void setViews(std::span<const CanvasView> views) override {
    require(views.size() <= kCanvasViews, "not too many views");
    for (const CanvasView& v : views) {
      require(v.rect.width > 0 && v.rect.height > 0 && v.farthest > v.camera.nearest, "a view is empty");
    }
    views_.assign(views.begin(), views.end());
  }
  void set(ItemId item, ItemKind kind, std::span<const Vec3f> places, std::span<const Rgb> colors) override {
    require(places.size() == static_cast<std::size_t>(kind) * colors.size(), "a colour each");
    Item& i = items[item];
    i.kind = kind;
    i.places.assign(places.begin(), places.end());
    i.colors.assign(colors.begin(), colors.end());
    i.shown.reset();
  }
  void setColors(ItemId item, std::span<const Rgb> colors) override {
    Item& i = itemOf(item);
    require(colors.size() == i.colors.size(), "as many colours as before");
    i.colors.assign(colors.begin(), colors.end());
  }
  void show(ItemId item, std::optional<std::vector<std::uint32_t>> indices) override {
    Item& i = itemOf(item);
    i.shown = std::move(indices);
    if (!i.shown) return;
    require(std::ranges::is_sorted(*i.shown), "indices ascend");
    require(i.shown->empty() || i.shown->back() < i.colors.size(), "indices are within the item");
  }
  void setLook(ItemId item, const ItemLook& look) override { itemOf(item).look = look; }
  void drop(ItemId item) override { items.erase(item); }
  void setImage(ImageId image, int width, int height, std::span<const Rgba> pixels) override {
    require(pixels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height), "an image's pixels");
    images_[image] = {width, height, {pixels.begin(), pixels.end()}};
  }
  void setOverlay(Overlay overlay) override {
    for (const std::uint32_t corner : overlay.corners) require(corner < overlay.vertices.size(), "a corner's vertex");
    for (const OverlayPart& part : overlay.parts) {
      require(part.first + part.count <= overlay.corners.size() && part.count % 3 == 0, "a part's corners");
      require(images_.contains(part.image), "a part's image");
    }
    overlay_ = std::move(overlay);
    painted_.clear();
  }
  void render(std::uint64_t maxPoints) override {
    ++renders;
    lastMost = maxPoints;
  }

  Image read() override {
    Image image(width_, height_, {});
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const Rgba& o = overlay()[i];
      image.pixels[i] = mix(image.pixels[i], {o[0], o[1], o[2]}, o[3] / 255.0);
    }
    return image;
  }

  void run(int, const std::function<bool(const CanvasEvent&)>&) override {}

  const std::vector<CanvasView>& views() const { return views_; }
  // Of an item of points: those that are drawn.
  std::vector<std::uint32_t> shownOf(ItemId item) const {
    const Item& i = items.at(item);
    if (i.shown) return *i.shown;
    std::vector<std::uint32_t> all(i.colors.size());
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<std::uint32_t>(k);
    return all;
  }
  std::vector<ItemId> pointItems() const {
    std::vector<ItemId> ids;
    for (const auto& [id, item] : items) {
      if (item.kind == ItemKind::Points) ids.push_back(id);
    }
    return ids;
  }

  // What lies over the views, a pixel each of the canvas: alpha 0 where nothing does.
  const std::vector<Rgba>& overlay() const {
    if (painted_.empty()) {
      painted_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), Rgba{});
      for (const OverlayPart& part : overlay_.parts) {
        for (std::size_t i = part.first; i < part.first + part.count; i += 3) paint(part, i);
      }
    }
    return painted_;
  }
  const Rgba& overlayAt(int x, int y) const { return overlay()[static_cast<std::size_t>(y * width_ + x)]; }
  bool isOverlay(int x, int y, const Rgb& color) const {
    const Rgba& o = overlayAt(x, y);
    return o[3] == 255 && Rgb{o[0], o[1], o[2]} == color;
  }

  // A pixel of the overlay that has exactly this colour, as have its neighbours: a legend's sample of it.
  std::optional<std::pair<int, int>> inOverlay(const Rgb& color) const {
    for (int y = 1; y + 1 < height_; ++y) {
      for (int x = 1; x + 1 < width_; ++x) {
        const auto is = [&](int right, int down) { return isOverlay(x + right, y + down, color); };
        if (is(0, 0) && is(1, 0) && is(-1, 0) && is(0, 1) && is(0, -1)) return std::pair(x, y);
      }
    }
    return {};
  }

  std::map<ItemId, Item> items;
  int renders = 0;
  std::uint64_t lastMost = 0;

 private:
  // As the module does.
  Item& itemOf(ItemId item) {
    const auto found = items.find(item);
    if (found == items.end()) throw Error("the viewer's canvas: the canvas has no item " + std::to_string(item));
    return found->second;
  }
  static void require(bool holds, const char* what) {
    if (!holds) throw std::logic_error(what);
  }

  struct Picture {
    int width = 0;
    int height = 0;
    std::vector<Rgba> pixels;
  };

  // A triangle over what is there, by the pixels' middles.
  void paint(const OverlayPart& part, std::size_t first) const {
    const auto corner = [&](std::size_t k) -> const OverlayVertex& {
      return overlay_.vertices[overlay_.corners[first + k]];
    };
    const OverlayVertex& a = corner(0);
    const OverlayVertex& b = corner(1);
    const OverlayVertex& c = corner(2);
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (area == 0) return;
    const Picture& image = images_.at(part.image);
    const int left = std::max(static_cast<int>(std::min({a.x, b.x, c.x})), std::max(part.clip.left, 0));
    const int top = std::max(static_cast<int>(std::min({a.y, b.y, c.y})), std::max(part.clip.top, 0));
    const int right =
        std::min({static_cast<int>(std::max({a.x, b.x, c.x})) + 1, part.clip.left + part.clip.width, width_});
    const int bottom =
        std::min({static_cast<int>(std::max({a.y, b.y, c.y})) + 1, part.clip.top + part.clip.height, height_});
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const double px = x + 0.5;
        const double py = y + 0.5;
        const double inB = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area;
        const double inC = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
        const double inA = 1 - inB - inC;
        if (inA < 0 || inB < 0 || inC < 0) continue;
        const auto between = [&](double ofA, double ofB, double ofC) { return inA * ofA + inB * ofB + inC * ofC; };
        const auto texel = [](double share, int size) {
          return std::clamp(static_cast<int>(share * size), 0, size - 1);
        };
        const auto u = static_cast<std::size_t>(texel(between(a.u, b.u, c.u), image.width));
        const auto v = static_cast<std::size_t>(texel(between(a.v, b.v, c.v), image.height));
        const Rgba& texture = image.pixels[v * static_cast<std::size_t>(image.width) + u];
        std::array<double, 4> color{};
        for (std::size_t k = 0; k < 4; ++k) color[k] = between(a.color[k], b.color[k], c.color[k]) * texture[k] / 255;
        Rgba& under =
            painted_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
        const double alpha = color[3] / 255;
        for (std::size_t k = 0; k < 3; ++k) {
          under[k] = static_cast<std::uint8_t>(std::lround(color[k] * alpha + under[k] * (1 - alpha)));
        }
        under[3] = static_cast<std::uint8_t>(std::lround(255 * (alpha + under[3] / 255.0 * (1 - alpha))));
      }
    }
  }

  int width_;
  int height_;
  std::vector<CanvasView> views_;
  std::map<ImageId, Picture> images_;
  Overlay overlay_;
  mutable std::vector<Rgba> painted_;  // empty: not yet
};

}  // namespace scanmill
