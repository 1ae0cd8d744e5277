#pragma once

// A canvas in memory: remembers what it was given and draws points as plain squares, the same on every machine.

#include <algorithm>
#include <limits>
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
    enum class Kind { Points, Triangles, Lines } kind = Kind::Points;
    std::vector<Vec3f> places;
    std::vector<Rgb> colors;
    std::optional<std::vector<std::uint32_t>> shown;  // none: all
    ItemLook look;
  };

  FakeCanvas(int width, int height) : width_(width), height_(height) {}

  std::string device() const override { return "none"; }
  int width() const override { return width_; }
  int height() const override { return height_; }
  void resize(int width, int height) override {
    width_ = width;
    height_ = height;
  }
  void setViews(std::span<const CanvasView> views) override {
    for (const CanvasView& v : views) {
      require(v.rect.width > 0 && v.rect.height > 0 && v.farthest > v.camera.nearest, "a view is empty");
    }
    views_.assign(views.begin(), views.end());
  }
  void setPoints(ItemId item, std::span<const Vec3f> positions, std::span<const Rgb> colors) override {
    set(item, Item::Kind::Points, positions, colors, 1);
  }
  void setTriangles(ItemId item, std::span<const Vec3f> corners, std::span<const Rgb> colors) override {
    set(item, Item::Kind::Triangles, corners, colors, 3);
  }
  void setLines(ItemId item, std::span<const Vec3f> ends, std::span<const Rgb> colors) override {
    set(item, Item::Kind::Lines, ends, colors, 2);
  }
  void setColors(ItemId item, std::span<const Rgb> colors) override {
    Item& i = itemOf(item);
    require(colors.size() == i.colors.size(), "as many colours as before");
    i.colors.assign(colors.begin(), colors.end());
  }
  void showAll(ItemId item) override { itemOf(item).shown.reset(); }
  void showOnly(ItemId item, std::span<const std::uint32_t> indices) override {
    Item& i = itemOf(item);
    require(std::is_sorted(indices.begin(), indices.end()), "indices ascend");
    require(indices.empty() || indices.back() < i.colors.size(), "indices are within the item");
    i.shown.emplace(indices.begin(), indices.end());
  }
  void setLook(ItemId item, const ItemLook& look) override { itemOf(item).look = look; }
  void drop(ItemId item) override { items.erase(item); }
  void setOverlay(int width, int height, std::span<const Rgba> pixels) override {
    require(pixels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height), "an overlay's pixels");
    overlayWidth = width;
    overlay.assign(pixels.begin(), pixels.end());
  }
  void render(std::uint64_t mostPoints) override {
    ++renders;
    lastMost = mostPoints;
  }

  Image read() override {
    Image image(width_, height_, {});
    for (std::size_t v = 0; v < views_.size(); ++v) drawView(image, v);
    for (std::size_t i = 0; i < overlay.size(); ++i) {
      const auto x = static_cast<int>(i % static_cast<std::size_t>(overlayWidth));
      const auto y = static_cast<int>(i / static_cast<std::size_t>(overlayWidth));
      if (!image.contains(x, y)) continue;
      const Rgba& o = overlay[i];
      image.at(x, y) = mix(image.at(x, y), {o[0], o[1], o[2]}, o[3] / 255.0);
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
      if (item.kind == Item::Kind::Points) ids.push_back(id);
    }
    return ids;
  }

  std::map<ItemId, Item> items;
  std::vector<Rgba> overlay;
  int overlayWidth = 0;
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
  void set(ItemId item, Item::Kind kind, std::span<const Vec3f> places, std::span<const Rgb> colors,
           std::size_t placesEach) {
    require(places.size() == placesEach * colors.size(), "a colour each");
    Item& i = items[item];
    i.kind = kind;
    i.places.assign(places.begin(), places.end());
    i.colors.assign(colors.begin(), colors.end());
    i.shown.reset();
  }

  void drawView(Image& image, std::size_t number) const {
    const CanvasView& view = views_[number];
    const PixelRect& rect = view.rect;
    fillRectangle(image, rect.left, rect.top, rect.width, rect.height, view.background);
    std::vector<double> depths(image.pixels.size(), std::numeric_limits<double>::infinity());
    for (const ItemId id : pointItems()) {
      const Item& item = items.at(id);
      if ((item.look.views >> number & 1) == 0) continue;
      for (const std::uint32_t i : shownOf(id)) {
        if (!isFinite(item.places[i])) continue;
        const Projected p = view.camera.project(item.look.canvasFromItem * Vec3d(item.places[i]));
        if (!(p.depth >= view.camera.nearest && p.depth <= view.farthest)) continue;
        if (!(std::abs(p.x) < 1e6 && std::abs(p.y) < 1e6)) continue;
        const double half = item.look.size / 2;
        for (int y = static_cast<int>(std::ceil(p.y - half - 0.5)); y + 0.5 < p.y + half; ++y) {
          for (int x = static_cast<int>(std::ceil(p.x - half - 0.5)); x + 0.5 < p.x + half; ++x) {
            if (x < 0 || y < 0 || x >= rect.width || y >= rect.height) continue;
            const std::size_t pixel = static_cast<std::size_t>(rect.top + y) * static_cast<std::size_t>(image.width) +
                                      static_cast<std::size_t>(rect.left + x);
            if (pixel >= depths.size() || p.depth >= depths[pixel]) continue;
            depths[pixel] = p.depth;
            image.pixels[pixel] = item.colors[i];
          }
        }
      }
    }
  }

  int width_;
  int height_;
  std::vector<CanvasView> views_;
};

}  // namespace scanmill
