// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.hpp"
#include "simulate/object.hpp"
#include "simulate/trace.hpp"

namespace scanmill::simulate {
namespace {

std::unique_ptr<Object> object_named(std::string_view name) { return std::move(make_object(name)).value(); }

Vec3 anywhere(Random& random, const Bounds& box, double margin) {
  return {random.uniform(box.low.x - margin, box.high.x + margin),
          random.uniform(box.low.y - margin, box.high.y + margin),
          random.uniform(box.low.z - margin, box.high.z + margin)};
}

class EveryObject : public testing::TestWithParam<std::string_view> {
 protected:
  std::unique_ptr<Object> object_ = object_named(GetParam());
};

TEST_P(EveryObject, HasADistanceThatNeverChangesFasterThanThePlace) {
  Random random(3, 0, 0);
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 a = anywhere(random, object_->bounds(), 5);
    const double reach = i % 2 == 0 ? 0.1 : 10;
    const Vec3 b =
        a + Vec3{random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
    worst = std::max(worst, std::abs(object_->distance(a) - object_->distance(b)) / norm(a - b));
  }
  EXPECT_LE(worst, 1 + 1e-9);
}

TEST_P(EveryObject, HasSamplesOnItsSurfaceAndInsideItsBounds) {
  const auto samples = sample_surface(*object_, 20000, 4);
  ASSERT_EQ(samples.size(), 20000u);
  const Bounds box = object_->bounds();
  for (const Vec3& p : samples) {
    ASSERT_LE(std::abs(object_->distance(p)), 1e-9);
    ASSERT_LE(std::abs(object_->surface_distance(p)), 1e-7);
    ASSERT_TRUE(p.x >= box.low.x - 1e-6 && p.y >= box.low.y - 1e-6 && p.z >= box.low.z - 1e-6);
    ASSERT_TRUE(p.x <= box.high.x + 1e-6 && p.y <= box.high.y + 1e-6 && p.z <= box.high.z + 1e-6);
  }
  EXPECT_EQ(samples, sample_surface(*object_, 20000, 4));
  EXPECT_NE(samples, sample_surface(*object_, 20000, 5));
}

TEST_P(EveryObject, HasASurfaceDistanceThatAgreesWithTheNearestSample) {
  const auto samples = sample_surface(*object_, 80000, 6);
  Random random(7, 0, 0);
  for (int i = 0; i < 200; ++i) {
    const Vec3 near = samples[random.next() % samples.size()];
    const Vec3 p = near + Vec3{random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)};
    double nearest2 = 1e300;
    for (const Vec3& s : samples) nearest2 = std::min(nearest2, norm2(s - p));
    const double distance = object_->surface_distance(p);
    EXPECT_EQ(distance < 0, object_->distance(p) < 0);
    EXPECT_GE(std::abs(distance), std::abs(object_->distance(p)) - 1e-9);
    EXPECT_LE(std::abs(distance), std::sqrt(nearest2) + 1e-9);
    EXPECT_GE(distance * distance + 1.3 * 1.3, nearest2) << "samples are at most 1.3 mm from any place of the surface";
  }
}

TEST_P(EveryObject, IsOneBodyWithoutCavity) {
  // Cubes around the centres that are inside, as a closed complex.
  const double h = 0.5;
  const Bounds box = object_->bounds();
  const auto count = [&](double low, double high) { return static_cast<int>((high - low) / h) + 5; };
  const int nx = count(box.low.x, box.high.x), ny = count(box.low.y, box.high.y), nz = count(box.low.z, box.high.z);
  auto at = [&](int i, int j, int k) { return static_cast<std::size_t>((k * ny + j) * nx + i); };
  std::vector<char> inside(static_cast<std::size_t>(nx * ny * nz), 0);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        inside[at(i, j, k)] = object_->distance(box.low + Vec3{i - 1.53, j - 1.51, k - 1.57} * h) < 0;
  // A cell of the complex exists when any cube around it is inside: V - E + F - C = 1 - handles + cavities, for one
  // body.
  int euler = 0;
  for (int k = 1; k < nz; ++k)
    for (int j = 1; j < ny; ++j)
      for (int i = 1; i < nx; ++i)
        for (int cell = 0; cell < 8; ++cell) {  // bit set: the cell extends along that axis
          bool any = false;
          for (int c = 0; c < 8; ++c)
            if ((c & cell) == 0) any = any || inside[at(i - (c & 1), j - (c >> 1 & 1), k - (c >> 2 & 1))];
          if (any) euler += (cell == 1 || cell == 2 || cell == 4 || cell == 7) ? -1 : 1;
        }
  auto pieces = [&](char kind) {
    std::vector<char> open(inside.size());
    for (std::size_t i = 0; i < inside.size(); ++i) open[i] = inside[i] == kind;
    int found = 0;
    for (std::size_t start = 0; start < open.size(); ++start) {
      if (!open[start]) continue;
      ++found;
      std::vector<std::size_t> stack{start};
      open[start] = 0;
      while (!stack.empty()) {
        const auto here = static_cast<int>(stack.back());
        stack.pop_back();
        const int i = here % nx, j = here / nx % ny, k = here / nx / ny;
        auto visit = [&](bool valid, int a, int b, int c) {
          if (valid && open[at(a, b, c)]) {
            open[at(a, b, c)] = 0;
            stack.push_back(at(a, b, c));
          }
        };
        visit(i > 0, i - 1, j, k), visit(i + 1 < nx, i + 1, j, k), visit(j > 0, i, j - 1, k);
        visit(j + 1 < ny, i, j + 1, k), visit(k > 0, i, j, k - 1), visit(k + 1 < nz, i, j, k + 1);
      }
    }
    return found;
  };
  EXPECT_EQ(pieces(1), 1);
  EXPECT_EQ(pieces(0), 1);
  EXPECT_EQ(euler, object_->name() == "torus" ? 0 : 1) << "a surface of twice this Euler number";
}

INSTANTIATE_TEST_SUITE_P(Objects, EveryObject, testing::ValuesIn(object_names().begin(), object_names().end()),
                         [](const auto& test) { return std::string(test.param); });

TEST(MakeObject, NamesTheNearestWhenThereIsNone) {
  const auto object = make_object("figurin");
  ASSERT_FALSE(object.ok());
  EXPECT_EQ(object.error().code, Code::BadUsage);
  EXPECT_NE(object.error().message.find("did you mean figurine?"), std::string::npos) << object.error().message;
}

TEST(Handset, HasTheExactDistanceBesideFacesEdgesAndCreases) {
  const auto handset = object_named("handset");
  // The vertical crease between grip and mouthpiece is at x = 51.3, y = 14.3; a point deep in both by 0.1 is nearest to
  // it.
  EXPECT_NEAR(handset->surface_distance({51.4, 14.2, 10}), -std::sqrt(0.02), 1e-12);
  EXPECT_NEAR(handset->surface_distance({51.2, 14.4, 10}), 0.1, 1e-12);
  EXPECT_NEAR(handset->surface_distance({51.2, 14.1, 10}), -0.2, 1e-12);
  // Where the grip's top runs into the earpiece.
  EXPECT_NEAR(handset->surface_distance({-75.2 + 25.1 - 0.3, 0, 21.7 - 0.4}), -0.5, 1e-12);
  EXPECT_NEAR(handset->surface_distance({-75.2 + 25.1 + 0.3, 0, 21.7 + 0.4}), 0.3, 1e-12);
  // Outside the upper far corner of the mouthpiece, and on its axis far above.
  EXPECT_NEAR(handset->distance({100.5, 25.2, 36.5}), 1.3, 1e-12);
  EXPECT_NEAR(handset->distance({75, 0, 45.3}), 10, 1e-12);
  EXPECT_NEAR(handset->surface_distance({0, 0, 0.25}), -0.25, 1e-12);
  EXPECT_FALSE(handset->is_seen({0, 0, 0}));
  EXPECT_TRUE(handset->is_seen({0, 14.3, 0.01}));
}

TEST(Figurine, HasTheSizeAndRadiiThatItClaims) {
  const auto figurine = object_named("figurine");
  const auto samples = sample_surface(*figurine, 20000, 8);
  Bounds box;
  double most_convex = 0, most_concave = 0;
  for (const Vec3& p : samples) {
    box.add(p);
    const double e = 0.01;
    const Vec3 n = normal_at(*figurine, p);
    const Vec3 u = unit(cross(std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, n)), v = cross(n, u);
    const Vec3 along_u = (normal_at(*figurine, p + u * e) - normal_at(*figurine, p - u * e)) * (0.5 / e);
    const Vec3 along_v = (normal_at(*figurine, p + v * e) - normal_at(*figurine, p - v * e)) * (0.5 / e);
    const double a = dot(along_u, u), b = (dot(along_u, v) + dot(along_v, u)) / 2, c = dot(along_v, v);
    const double mean = (a + c) / 2, spread = std::sqrt((a - c) * (a - c) / 4 + b * b);
    most_convex = std::max(most_convex, mean + spread);
    most_concave = std::min(most_concave, mean - spread);
  }
  EXPECT_NEAR(box.size().x, 60, 0.5);
  EXPECT_NEAR(box.size().y, 40, 0.5);
  EXPECT_NEAR(box.size().z, 30, 0.5);
  EXPECT_GE(1 / most_convex, 2);
  EXPECT_GE(-1 / most_concave, 4);
  EXPECT_LE(-1 / most_concave, 5) << "it has real concavities";
}

TEST(Figurine, IsNowhereThinnerThanFiveMillimetres) {
  const auto figurine = object_named("figurine");
  for (const Vec3& p : sample_surface(*figurine, 5000, 9)) {
    const Ray inwards{p, -normal_at(*figurine, p)};
    EXPECT_GE(first_crossing(*figurine, inwards, {0.01, 50}, -1), 5) << p.x << " " << p.y << " " << p.z;
  }
}

TEST(Figurine, HasAnExactSurfaceDistanceAlongNormals) {
  const auto figurine = object_named("figurine");
  Random random(10, 0, 0);
  for (const Vec3& p : sample_surface(*figurine, 2000, 10)) {
    const double t = random.uniform(-1, 1);
    EXPECT_NEAR(figurine->surface_distance(p + normal_at(*figurine, p) * t), t, 1e-7);
  }
}

TEST(Figurine, HasAFiniteSurfaceDistanceFarFromItsSurface) {
  const auto figurine = object_named("figurine");
  Random random(12, 0, 0);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = anywhere(random, figurine->bounds(), 40);
    EXPECT_GE(std::abs(figurine->surface_distance(p)), std::abs(figurine->distance(p)) * 0.99);
    EXPECT_LE(std::abs(figurine->surface_distance(p)), 200);
  }
}

TEST(SampleSurface, IsUniformByArea) {
  const std::size_t n = 40000;
  // Sphere: a slab holds the share of its height. Torus, R 20, r 8: the outer half of the tube has 1/2 + r / (pi R).
  std::size_t upper = 0, outer = 0;
  for (const Vec3& p : sample_surface(*object_named("sphere"), n, 1)) upper += p.z > 10;
  for (const Vec3& p : sample_surface(*object_named("torus"), n, 1)) outer += p.x * p.x + p.y * p.y > 400;
  EXPECT_NEAR(static_cast<double>(upper) / n, 0.25, 0.01);
  EXPECT_NEAR(static_cast<double>(outer) / n, 0.5 + 8 / (3.14159265 * 20), 0.01);
}

}  // namespace
}  // namespace scanmill::simulate
