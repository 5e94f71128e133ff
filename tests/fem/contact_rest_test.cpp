#include "fem/contact_rest.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace struna::fem {
namespace {

ContactForceLaw spring(double stiffness) {
  return {ContactLaw::approach, stiffness, 0.0};
}

ClosedContact point(const ContactForceLaw& law, double gap, double x, double y,
                    StopShape shape = StopShape::bore) {
  ClosedContact c;
  c.law = &law;
  c.gap = gap;
  c.shape = shape;
  c.end_offset[0] = x;
  c.end_offset[1] = y;
  return c;
}

/// Largest |F - k g| over the largest force, with h = h_free - W n F formed anew from what was returned.
double imbalance(const std::vector<ClosedContact>& contacts, const Eigen::VectorXd& free, int d,
                 const RowMatrix& w) {
  Eigen::VectorXd force(free.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    for (int s = 0; s < d; ++s) {
      force[static_cast<long>(i) * d + s] = contacts[i].force * contacts[i].direction[s];
    }
  }
  const Eigen::VectorXd h = free - w * force;
  double worst = 0.0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ClosedContact& c = contacts[i];
    const Eigen::VectorXd at = h.segment(static_cast<long>(i) * d, d);
    const double distance = c.shape == StopShape::wall ? at[0] : at.norm();
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(d);
    if (distance > c.gap) {
      const double size = c.law->stiffness * (distance - c.gap);
      wanted = c.shape == StopShape::wall ? Eigen::VectorXd(size * Eigen::VectorXd::Unit(d, 0))
                                          : Eigen::VectorXd(size * at / distance);
    }
    worst = std::max(worst, (wanted - force.segment(static_cast<long>(i) * d, d)).norm());
  }
  return worst / std::max(force.cwiseAbs().maxCoeff(), 1e-300);
}

TEST(ContactRest, LeavesOpenPointsAlone) {
  const auto law = spring(1e5);
  std::vector<ClosedContact> contacts = {point(law, 1e-4, 5e-5, -5e-5)};
  ASSERT_TRUE(rest_in_contact(contacts, 2, 1e-3 * RowMatrix::Identity(2, 2)));
  EXPECT_EQ(contacts[0].force, 0.0);
  EXPECT_EQ(contacts[0].end_offset[0], 5e-5);
  EXPECT_LT(contacts[0].end_penetration, 0.0);
  std::vector<ClosedContact> none;
  EXPECT_TRUE(rest_in_contact(none, 2, RowMatrix()));
}

TEST(ContactRest, OnALineIsTwoSpringsInSeries) {
  const auto law = spring(1e4);
  for (const StopShape shape : {StopShape::bore, StopShape::wall}) {
    std::vector<ClosedContact> contacts = {point(law, 1e-3, 5e-3, 0.0, shape)};
    ASSERT_TRUE(rest_in_contact(contacts, 1, RowMatrix::Constant(1, 1, 1e-3)));
    EXPECT_NEAR(contacts[0].force, 4e-3 / (1e-4 + 1e-3), 1e-12);  // rounding
  }
}

TEST(ContactRest, TurnsWhereTheFreeOffsetLiesManyGapsAway) {
  // One point whose flexibility is three times larger in one direction than across it.
  RowMatrix w(2, 2);
  w << 1e-3, 4e-4, 4e-4, 3e-4;
  for (const double stiffness : {1e2, 1e5, 1e9}) {
    const auto law = spring(stiffness);
    for (const double ratio : {1.0, 3.0, 10.0, 1e3, 1e5}) {
      const Eigen::Vector2d free = ratio * 1e-4 * Eigen::Vector2d(1.0, 0.8);
      std::vector<ClosedContact> contacts = {point(law, 1e-4, free[0], free[1])};
      ASSERT_TRUE(rest_in_contact(contacts, 2, w)) << stiffness << ' ' << ratio;
      // Rounding of the free offset, k eps h against F ~ h/W: eps k W.
      EXPECT_LT(imbalance(contacts, free, 2, w), 1e-15 * (1e3 + stiffness * 1e-3))
          << stiffness << ' ' << ratio;
    }
  }
}

TEST(ContactRest, ManyPointsOnFewModesBalance) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 60; ++trial) {
    const int points = 1 + trial % 30;
    const int modes = 3 + trial % 17;  // fewer than the components: W is singular
    Eigen::MatrixXd rows(2 * points, modes);
    for (long i = 0; i < rows.size(); ++i) rows.data()[i] = uniform(random);
    Eigen::VectorXd compliance(modes);
    for (int m = 0; m < modes; ++m) compliance[m] = 1e-3 * std::pow(m + 1.0, -3.0);
    const RowMatrix w = rows * compliance.asDiagonal() * rows.transpose();
    Eigen::VectorXd sag(modes);
    for (int m = 0; m < modes; ++m) sag[m] = 1e-2 * uniform(random) / (m + 1.0);
    const Eigen::VectorXd free = rows * sag;
    const double stiffness = std::pow(10.0, 3.0 + trial % 5);
    const auto law = spring(stiffness);
    std::vector<ClosedContact> contacts;
    for (int i = 0; i < points; ++i) contacts.push_back(point(law, 5e-5, free[2 * i], free[2 * i + 1]));
    ASSERT_TRUE(rest_in_contact(contacts, 2, w)) << trial;
    EXPECT_LT(imbalance(contacts, free, 2, w), 1e-14 * (1e3 + stiffness)) << trial;  // rounding: eps k W
  }
}

TEST(ContactRest, TellsWhatHasNone) {
  const auto law = spring(1e5);
  std::vector<ClosedContact> contacts = {point(law, 1e-4, NAN, 0.0)};
  EXPECT_FALSE(rest_in_contact(contacts, 2, 1e-3 * RowMatrix::Identity(2, 2)));
  contacts = {point(law, 1e-4, 1.0, 0.0)};
  EXPECT_FALSE(rest_in_contact(contacts, 2, INFINITY * RowMatrix::Identity(2, 2)));
}

}  // namespace
}  // namespace struna::fem
