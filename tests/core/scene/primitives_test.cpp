#include "scene/primitives.h"

#include <map>
#include <set>

#include "tests/support/test_scene.h"

namespace scanmill {
namespace {

Mesh make() {
  Mesh mesh;
  mesh.surfaces.resize(1);
  return mesh;
}

// Divergence theorem: the sum of the signed tetrahedra under the triangles. Positive where normals point outwards.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) {
    const auto [a, b, c] = cornersIn(mesh, t);
    sum += dot(a, cross(b, c)) / 6;
  }
  return sum;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const Triangle& t : mesh.triangles) sum += length(normalIn(mesh, t)) / 2;
  return sum;
}

// Closed and consistently turned: each directed edge is there once, and so is its reverse.
bool isWatertight(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    const auto reverse = edges.find({edge.first.second, edge.first.first});
    return edge.second == 1 && reverse != edges.end() && reverse->second == 1;
  });
}

// Vertices - edges + faces.
long eulerCharacteristic(const Mesh& mesh) {
  std::set<std::uint32_t> vertices;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      vertices.insert(t[i]);
      edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
    }
  }
  return long(vertices.size()) - long(edges.size()) + long(mesh.triangles.size());
}

// For shapes that are convex and hold the origin.
void expectOutward(const Mesh& mesh) {
  for (const Triangle& t : mesh.triangles) EXPECT_GT(dot(normalIn(mesh, t), cornersIn(mesh, t)[0]), 0);
}

void expectClosedSolid(Mesh mesh, double expectedVolume, double expectedArea, double tolerance = 1e-6) {
  EXPECT_TRUE(isWatertight(mesh));
  EXPECT_EQ(eulerCharacteristic(mesh), 2);
  EXPECT_NEAR(volume(mesh), expectedVolume, tolerance * expectedVolume);
  EXPECT_NEAR(area(mesh), expectedArea, tolerance * expectedArea);
  expectOutward(mesh);
  EXPECT_EQ(mesh.surfaceOf.size(), mesh.triangles.size());
  EXPECT_EQ(clean(mesh).total(), 0u);
}

// Of a regular polygon with n corners on a circle.
double polygonArea(double radius, int n) {
  return n / 2.0 * radius * radius * std::sin(2 * kPi / n);
}
double polygonSide(double radius, int n) {
  return 2 * radius * std::sin(kPi / n);
}

TEST(Primitives, box) {
  Mesh mesh = make();
  appendBox(mesh, 0, {}, {1, 2, 3});
  expectClosedSolid(mesh, 6, 22);
  EXPECT_EQ(mesh.bounds().low, (Vec3d{-0.5, -1, -1.5}));
  EXPECT_EQ(mesh.bounds().high, (Vec3d{0.5, 1, 1.5}));
}

TEST(Primitives, cylinderIsAPrism) {
  for (const int n : {3, 7, 32}) {
    Mesh mesh = make();
    appendCylinder(mesh, 0, {}, 0.5, 0.5, 4, n);
    expectClosedSolid(mesh, polygonArea(0.5, n) * 4, 2 * polygonArea(0.5, n) + n * polygonSide(0.5, n) * 4);
  }
}

TEST(Primitives, coneIsAPyramid) {
  const int n = 24;
  for (const bool pointsUp : {true, false}) {
    Mesh mesh = make();
    appendCylinder(mesh, 0, {}, pointsUp ? 2 : 0, pointsUp ? 0 : 2, 3, n);
    const double slant = std::hypot(3.0, 2 * std::cos(kPi / n));
    expectClosedSolid(mesh, polygonArea(2, n) * 3 / 3, polygonArea(2, n) + n * polygonSide(2, n) * slant / 2);
    EXPECT_EQ(mesh.triangles.size(), std::size_t(2 * n));
  }
}

TEST(Primitives, frustum) {
  const int n = 40;
  Mesh mesh = make();
  appendCylinder(mesh, 0, {}, 2, 1, 3, n);
  const double slant = std::hypot(3.0, std::cos(kPi / n));
  expectClosedSolid(mesh, polygonArea(1, n) * 3 * (4 + 2 + 1) / 3.0,
                    polygonArea(2, n) + polygonArea(1, n) + n * (polygonSide(2, n) + polygonSide(1, n)) / 2 * slant);
}

// The error of an inscribed polyhedron falls with the square of the step: four times when the segments double.
TEST(Primitives, sphereAndCapsuleConvergeWithTheSquareOfTheStep) {
  for (const double height : {0.0, 1.5}) {
    const double exactVolume = 4.0 / 3 * kPi * 8 + kPi * 4 * height;
    const double exactArea = 4 * kPi * 4 + 2 * kPi * 2 * height;
    double volumeError[2];
    double areaError[2];
    for (int i = 0; i < 2; ++i) {
      Mesh mesh = make();
      if (height > 0) {
        appendCapsule(mesh, 0, {}, 2, height, 32 << i);
      } else {
        appendSphere(mesh, 0, {}, 2, 32 << i);
      }
      expectClosedSolid(mesh, exactVolume, exactArea, 0.02);
      volumeError[i] = exactVolume - volume(mesh);
      areaError[i] = exactArea - area(mesh);
      EXPECT_NEAR(mesh.bounds().high.z, 2 + height / 2, 1e-6);
      EXPECT_NEAR(mesh.bounds().high.x, 2, 1e-6);
    }
    EXPECT_NEAR(volumeError[0] / volumeError[1], 4, 0.1);
    EXPECT_NEAR(areaError[0] / areaError[1], 4, 0.1);
  }
}

TEST(Primitives, coarsestShapesAreStillClosed) {
  Mesh sphere = make();
  appendSphere(sphere, 0, {}, 1, 3);
  EXPECT_TRUE(isWatertight(sphere));
  EXPECT_EQ(eulerCharacteristic(sphere), 2);
  EXPECT_GT(volume(sphere), 0);
  Mesh capsule = make();
  appendCapsule(capsule, 0, {}, 1, 1, 3);
  EXPECT_TRUE(isWatertight(capsule));
  EXPECT_EQ(eulerCharacteristic(capsule), 2);
}

TEST(Primitives, planeFacesUp) {
  for (const int cells : {1, 5}) {
    Mesh mesh = make();
    appendPlane(mesh, 0, {}, 4, 6, cells);
    EXPECT_EQ(mesh.triangles.size(), std::size_t(2 * cells * cells));
    EXPECT_EQ(eulerCharacteristic(mesh), 1);  // a disc
    EXPECT_NEAR(area(mesh), 24, 1e-5);
    for (const Triangle& t : mesh.triangles) EXPECT_GT(normalIn(mesh, t).z, 0);
    EXPECT_EQ(mesh.bounds().low, (Vec3d{-2, -3, 0}));
  }
}

TEST(Primitives, quadTurnsAsItsCorners) {
  Mesh mesh = make();
  appendQuad(mesh, 0, {0, 0, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0});
  EXPECT_NEAR(area(mesh), 6, 1e-12);
  EXPECT_EQ(mesh.triangles[0], (Triangle{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[1], (Triangle{0, 2, 3}));
}

TEST(Primitives, placesScaleTurnAndMirrorWithoutTurningInsideOut) {
  const Mat3 turn = toMatrix(fromYawPitchRoll(0.4, -0.3, 1.1));
  for (const double sign : {1.0, -1.0}) {
    Mesh mesh = make();
    appendBox(mesh, 0, {turn * Mat3::scale({sign * 2, 3, 0.5}), {0, 0, 0}}, {1, 1, 1});
    expectClosedSolid(mesh, 3, 2 * (2 * 3 + 2 * 0.5 + 3 * 0.5), 1e-5);
  }
}

TEST(Primitives, appendingKeepsWhatIsThere) {
  Mesh mesh = make();
  mesh.surfaces.resize(2);
  appendBox(mesh, 0, {}, {1, 1, 1});
  mesh.uvs.resize(mesh.positions.size(), {0.25f, 0.5f});
  appendSphere(mesh, 1, {{}, {5, 0, 0}}, 1, 12);
  EXPECT_EQ(mesh.uvs.size(), mesh.positions.size());
  EXPECT_EQ(mesh.uvs[0].x, 0.25f);
  EXPECT_EQ(std::count(mesh.surfaceOf.begin(), mesh.surfaceOf.end(), 0), 12);
  EXPECT_TRUE(isWatertight(mesh));
  EXPECT_EQ(eulerCharacteristic(mesh), 4);  // two solids
  EXPECT_NEAR(mesh.bounds().high.x, 6, 1e-6);
}

}  // namespace
}  // namespace scanmill
