#pragma once

// The data that all parts of a viewer's session use: the frame, the options, the filter, and messages to the user.

#include <cstdint>
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
#include "viewer/frames/frame_source.h"
#include "viewer/window/redraw.h"
#include "viewer/window/view_options.h"

namespace scanmill {

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
