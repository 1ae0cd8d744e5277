// The viewer over scans whose beams have two returns, one or none.

#include "tests/core/sense/several_returns.h"

#include "tests/studio/viewer/window/session_world.h"
#include "viewer/window/picked_rows.h"

namespace scanmill {
namespace {

ViewScan viewOf(Scan scan, const std::string& name) {
  ViewScan view;
  view.name = name;
  view.scan = std::move(scan);
  return view;
}

std::size_t pointWith(const Scan& scan, const PointKey& key) {
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (keyOf(scan, i) == key && isFinite(scan.position[i])) return i;
  }
  throw std::runtime_error("no such point");
}

// Of 9 columns: beam 11 of ring 1, column 2 has two returns, beam 10 one, beam 9 none.
class ReturnRows : public testing::Test {
 protected:
  World world_ = makeSeveralReturns(4, 9);
  ViewScan dense_ = viewOf(senseOnce(world_, {}, {ColumnSet::all(), false}), "dense");
  ViewScan image_ = viewOf(senseOnce(world_, {}, {ColumnSet(kLabel), true}), "image");
};

TEST_F(ReturnRows, TellWhichOneItIs) {
  for (const ViewScan* view : {&dense_, &image_}) {
    for (const std::uint32_t number : {0u, 1u}) {
      const PickedThing thing = describePoint(*view, 0, pointWith(view->scan, {1, 2, number}), nullptr);
      EXPECT_EQ(rowOf(thing, "return"), std::to_string(number + 1)) << view->name;
      EXPECT_EQ(rowOf(thing, "ring"), "1");
      EXPECT_EQ(rowOf(thing, "column"), "2");
      EXPECT_EQ(rowOf(thing, "range"), number == 0 ? "10.000 m" : "15.000 m");
    }
  }
  EXPECT_EQ(rowOf(describePoint(dense_, 0, 0, nullptr), "cause"), "1");
}

TEST_F(ReturnRows, JoinByBeamAndReturn) {
  const auto ofOther = [](const ViewScan& own, const ViewScan& other, const PointKey& key) {
    PickedThing thing = describePoint(own, 0, pointWith(own.scan, key), nullptr);
    addSameBeam(thing, own.scan, other, nullptr);
    return rowOf(thing, other.name);
  };
  EXPECT_EQ(ofOther(dense_, image_, {1, 2, 0}), "10.00 m, class 1");
  EXPECT_EQ(ofOther(dense_, image_, {1, 2, 1}), "15.00 m, class 2");
  EXPECT_EQ(ofOther(image_, dense_, {1, 2, 1}), "15.00 m, class 2");
  EXPECT_EQ(ofOther(image_, dense_, {1, 1, 0}), "10.00 m, class 1");
  const ViewScan single = viewOf(senseOnce(makeWorld(4, 9, 12), {}, {ColumnSet(kRing, kColumn), false}), "single");
  EXPECT_EQ(ofOther(dense_, single, {1, 2, 0}), "12.00 m");
  EXPECT_EQ(ofOther(dense_, single, {1, 2, 1}), "no return");
}

}  // namespace
}  // namespace scanmill
