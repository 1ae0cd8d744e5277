#pragma once

// The data that all parts of a viewer's session use: the frame, the options, the filter, and messages to the user.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"
#include "scene/ontology.h"
#include "viewer/canvas/canvas.h"
#include "viewer/frames/frame_source.h"
#include "viewer/window/view_options.h"

namespace scanmill {

// The changes since the last picture.
struct Changes {
  bool views = true;       // cameras or rectangles of views
  bool items = true;       // points, lines or triangles
  bool panels = true;      // text and panels over the views
  bool highlight = false;  // points that are highlighted
  bool hover = false;      // the pointer, or what is under it
};

enum class Detail { Fast, AllPoints };  // Fast: as many points as can be drawn while something moves

// Decides when the canvas is drawn, and with how many points: with few points, to be fast, while something moves; with
// all points when nothing has changed for a while.
class RedrawScheduler {
 public:
  // `seconds`: a clock (s) that never goes back; empty: uses a clock that starts now.
  explicit RedrawScheduler(Canvas& canvas, std::function<double()> seconds = {});

  double now() const { return seconds_(); }  // returns the clock's time (s)
  const std::vector<CanvasView>& views() const { return views_; }

  // Passes the views to the canvas if a camera, an item or a rectangle has changed.
  void setViews(std::vector<CanvasView> views);
  // Draws a picture if something has changed or, with AllPoints, if the last picture lacks points. `points`: number of
  // points that the items show together; `items`: number of items with points. `began`: the time at which the work for
  // this picture began.
  void draw(Detail detail, std::uint64_t points, std::size_t items, double began);

  // True if enough time has passed since the last picture to draw a new one after a move of the pointer.
  bool mayFollowPointer() const;
  // True if the last picture lacks points, and nothing has changed for so long that all points should be drawn.
  bool allPointsDue() const;
  // True if a picture of all points takes so long that highlighting waits until the pointer rests.
  bool isSlow() const;
  bool drawnOnce() const { return lastPicture_ > 0; }

  Changes changes;

 private:
  std::uint64_t pointsPerItem(std::uint64_t total, std::size_t items) const;
  void updateSpeed(std::uint64_t points, double ms);

  Canvas& canvas_;
  std::function<double()> seconds_;
  std::vector<CanvasView> views_;
  double pointsPerMs_ = 20'000;      // drawing speed, estimated from the time that previous pictures took
  bool partial_ = false;             // true: the last picture did not show all points
  std::uint64_t lastMaxPoints_ = 0;  // maximum number of points per item in the last picture; 0: no limit
  double lastChange_ = 0;            // time of the last change of cameras, views or items (s)
  double allPointsSeconds_ = 0;      // duration of drawing the last picture of all points (s)
  double lastPicture_ = 0;           // time of the last picture (s)
  double pictureSeconds_ = 0;        // duration of the last picture, including the work before drawing (s)
};

// A filter by class id. It is independent of the quantity that colours show.
class ClassFilter {
 public:
  ClassFilter() = default;
  // `names`: names, aliases or ids of the classes to hide or, if `only` is true, to show alone; empty: all are shown.
  // Throws InputError for a name that the ontology lacks; without an ontology only ids are accepted.
  ClassFilter(const std::vector<std::string>& names, bool only, const Ontology* ontology);

  bool shows(std::uint16_t id) const { return listed_.contains(id) == only_; }
  bool showsAll() const { return !only_ && listed_.empty(); }
  void toggle(std::uint16_t id);
  // Shows this class alone.
  void showOnly(std::uint16_t id);
  // Returns a description, such as "without road, car" or "only road"; empty if all classes are shown.
  std::string text(const Ontology* ontology) const;

 private:
  bool only_ = false;  // true: `listed_` are the shown classes; false: the hidden classes
  std::set<std::uint16_t> listed_;
};

// A message that is shown for some seconds.
struct ViewNotice {
  std::string text;
  double until = 0;                    // time of RedrawScheduler::now() at which the message disappears (s)
  const ViewCommand* cause = nullptr;  // the command whose key caused the message; null: no key did
};

// Selects the points and triangles that are shown.
struct ShownFilter {
  ClassFilter classes;
  std::set<std::uint32_t> instances;  // ids of the only instances that are shown; empty: all are shown
  std::optional<CloseUp> closeUp;     // only points in this ball are shown; absent: all are shown
  std::set<std::string> hiddenScans;  // names of the scans that the overlay of all scans does not show

  bool showsInstance(std::uint32_t id) const { return instances.empty() || instances.contains(id); }
};

struct SessionContext {
  SessionContext(std::shared_ptr<const FrameSource> frames, Canvas& drawnOn, const ViewOptions& chosen)
      : source(std::move(frames)),
        canvas(drawnOn),
        options(chosen),
        redraw(drawnOn),
        filter{ClassFilter(chosen.hidden, chosen.only, source->ontology()),
               {chosen.instances.begin(), chosen.instances.end()},
               chosen.closeUp,
               {}} {}

  // Returns the number of scans in the frame; 0 if there is no frame.
  std::size_t scanCount() const { return frame ? frame->scans.size() : 0; }
  // Shows a message for some seconds.
  void notify(const std::string& text, double seconds = 4);
  // Shows a message for longer than notify() does by default. The same message is shown only once in a session.
  void hint(const std::string& text);

  std::shared_ptr<const FrameSource> source;
  Canvas& canvas;
  ViewOptions options;  // the options at the start, changed by the user's actions since
  RedrawScheduler redraw;
  Changes& changes = redraw.changes;
  std::shared_ptr<const ViewFrame> frame;  // the frame that is shown; null: no frame has been loaded yet
  ShownFilter filter;
  std::vector<ViewNotice> notices;
  std::vector<std::string> hints;
  const ViewCommand* executing = nullptr;  // the command whose key is being handled
};

struct InstanceSummary {
  std::uint32_t id = 0;
  std::vector<std::uint32_t> points;  // indices of the instance's finite points, ascending
  // Pairs of class id and number of points, the most frequent class first; empty if the scan has no labels.
  std::vector<std::pair<std::uint16_t, std::uint64_t>> classes;
  // The smallest upright box that contains the points. `size`: longer side, shorter side and height (m).
  // `levelFromBox`: transform from the box's frame, with x along the longer side and the origin at the box's centre, to
  // the level frame (z vertical).
  Vec3d size;
  Affine levelFromBox;
};

// Summarises the instances that have finite points, in the order of their ids: all except 0 or, if `only` is given,
// this one. `positions`: positions of the scan's points (m). `levelFromPoints`: transform from the frame of `positions`
// to a frame whose z axis is vertical.
std::vector<InstanceSummary> summarizeInstances(const Scan& scan, std::span<const Vec3f> positions,
                                                const Affine& levelFromPoints,
                                                std::optional<std::uint32_t> only = std::nullopt);

}  // namespace scanmill
