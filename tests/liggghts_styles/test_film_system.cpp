#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>
#include <vector>

#include "liggghts_styles/film_system.hpp"

namespace bedload {
namespace {

struct Link {
  int i, j;  // j = -1: a wall
  Eigen::Vector3d normal;
  double compliance, alone;
};

/// Films between 40 spheres and at walls, every film of which is stiff or soft; sphere 0 is held.
struct Cluster {
  static constexpr int spheres = 40;
  std::vector<double> inverse_mass;
  std::vector<Link> links;

  Cluster() {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0.5, 2.0);
    for (int n = 0; n < spheres; ++n) inverse_mass.push_back(n == 0 ? 0.0 : uniform(random));
    std::uniform_int_distribution<int> sphere(-1, spheres - 2);
    for (int n = 0; n < 150; ++n) {
      const int i = 1 + n % (spheres - 1), other = sphere(random),
                j = other < i ? other : other + 1;
      const double own = inverse_mass[i] + (j < 0 ? 0.0 : inverse_mass[j]);
      const Eigen::Vector3d direction(normal(random), normal(random), normal(random));
      links.push_back(
          {i, j, direction.normalized(), own * (n % 3 == 0 ? 50.0 : 1.01), normal(random)});
    }
  }
  double of(int sphere) const { return sphere < 0 ? 0.0 : inverse_mass[sphere]; }

  /// D F_alone = (D + A - diag A) F, A written out.
  Eigen::VectorXd exact() const {
    const auto count = static_cast<Eigen::Index>(links.size());
    Eigen::MatrixXd matrix(count, count);
    Eigen::VectorXd right(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Link& gap = links[k];
      right[k] = gap.compliance * gap.alone;
      for (Eigen::Index l = 0; l < count; ++l) {
        const Link& force = links[l];
        // Acceleration of sphere s by a unit force of film l.
        const auto pushed = [&](int s) -> Eigen::Vector3d {
          const double sign = (s == force.i ? 1.0 : 0.0) - (s >= 0 && s == force.j ? 1.0 : 0.0);
          return sign * of(s) * force.normal;
        };
        matrix(k, l) = k == l ? gap.compliance : gap.normal.dot(pushed(gap.i) - pushed(gap.j));
      }
    }
    return matrix.partialPivLu().solve(right);
  }
};

const FilmSystem::Ranks one_rank{[] {}, [](std::span<double>) {}};

// The sum of the forces' squares is known to 1e-8 of itself in the norm of D, whose numbers differ
// by a hundred; a term of A left out or turned in sign changes forces by some per cent.
TEST(FilmSystem, ForcesAreThoseOfTheWholeLinearSystem) {
  const Cluster cluster;
  FilmSystem system;
  system.begin(Cluster::spheres, cluster.links.size());
  for (const Link& link : cluster.links)
    system.add(link.i, link.j, {link.normal[0], link.normal[1], link.normal[2]}, cluster.of(link.i),
               cluster.of(link.j), link.compliance, link.alone, 1.0);
  ASSERT_TRUE(system.solve(1e-10, 1000, one_rank));
  const Eigen::VectorXd exact = cluster.exact();
  for (std::size_t k = 0; k < cluster.links.size(); ++k)
    EXPECT_NEAR(system.force(k), exact[static_cast<Eigen::Index>(k)], 1e-7 * exact.norm()) << k;
}

// A film through a periodic end is held twice, from either side, with half its share; each pushes
// its own sphere. A film that pushed both, or none, would be off by as much as the whole.
TEST(FilmSystem, FilmsHeldFromBothSidesAreOne) {
  const Cluster cluster;
  FilmSystem whole, halves;
  const auto add = [&](FilmSystem& system, int i, int j, const Eigen::Vector3d& n, const Link& link,
                       double share) {
    system.add(i, j, {n[0], n[1], n[2]}, cluster.of(i), cluster.of(j), link.compliance, link.alone,
               share);
  };
  const auto at_walls = static_cast<std::size_t>(std::count_if(
      cluster.links.begin(), cluster.links.end(), [](const Link& link) { return link.j < 0; }));
  whole.begin(Cluster::spheres, cluster.links.size());
  halves.begin(Cluster::spheres, 2 * cluster.links.size() - at_walls);
  for (const Link& link : cluster.links) {
    add(whole, link.i, link.j, link.normal, link, 1.0);
    if (link.j < 0) {
      add(halves, link.i, link.j, link.normal, link, 1.0);
      continue;
    }
    add(halves, link.i, link.j, link.normal, link, 0.5);
    add(halves, link.j, link.i, -link.normal, link, 0.5);
  }
  ASSERT_TRUE(whole.solve(1e-10, 1000, one_rank));
  ASSERT_TRUE(halves.solve(1e-10, 1000, one_rank));
  std::size_t half = 0;
  for (std::size_t k = 0; k < cluster.links.size(); ++k) {
    EXPECT_NEAR(halves.force(half), whole.force(k), 1e-7) << k;
    if (cluster.links[k].j >= 0) EXPECT_NEAR(halves.force(half + 1), whole.force(k), 1e-7) << k;
    half += cluster.links[k].j < 0 ? 1 : 2;
  }
}

TEST(FilmSystem, AFilmThatSharesNoSphereKeepsItsForce) {
  FilmSystem system;
  system.begin(3, 2);
  system.add(0, 1, {0.6, 0.0, 0.8}, 1.3, 0.7, 2.1, 0.123456789, 1.0);
  system.add(2, -1, {0.0, 1.0, 0.0}, 1.1, 0.0, 1.2, -0.3, 1.0);
  ASSERT_TRUE(system.solve(1e-8, 200, one_rank));
  EXPECT_EQ(system.force(0), 0.123456789);
  EXPECT_EQ(system.force(1), -0.3);
}

TEST(FilmSystem, WithoutFilmsThereIsNothingToSolve) {
  FilmSystem system;
  system.begin(5, 0);
  EXPECT_FALSE(system.solve(1e-8, 200, one_rank));
}

}  // namespace
}  // namespace bedload
