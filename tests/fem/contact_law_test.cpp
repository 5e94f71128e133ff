#include "fem/contact_law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

struct Known {
  double damping_ratio;
  double restitution;
};

TEST(ContactLaw, NoAdhesionRestitutionMeetsHighPrecisionValues) {
  // From the mp integration of m x'' = -max(0, k x + c x'), to 15 digits; rounding of a few operations
  // allowed.
  const Known known[] = {{.01, .969264750464492},
                         {.05, .858758101775092},
                         {.1, .74407939772178},
                         {.2, .571740027584777},
                         {.3, .450975452893128},
                         {.5, .298436059192275},
                         {1 / std::sqrt(2.0), .207879576350762},
                         {.9, .155282747501682},
                         {2, .0477687325056202},
                         {4.09, .0135223485097372},
                         {5.334, .00821471620777862}};
  for (const Known& k : known)
    EXPECT_NEAR(no_adhesion_restitution(k.damping_ratio), k.restitution, 3e-15) << k.damping_ratio;
}

TEST(ContactLaw, ApproachRestitutionMeetsItsClosedForm) {
  const Known known[] = {{.1, .862600}, {.5, .546293}, {2, .218561}, {5.334, .090635}};
  // Six digits are what the reference gives.
  for (const Known& k : known)
    EXPECT_NEAR(approach_restitution(k.damping_ratio), k.restitution, 5e-7) << k.damping_ratio;
}

TEST(ContactLaw, RestitutionFormulasAreContinuousThroughCriticalDamping) {
  for (const auto& e : {approach_restitution, no_adhesion_restitution}) {
    // Slope is of order one: 2e-7 apart in zeta is 2e-7 apart in e, and the 0/0 costs half the digits.
    EXPECT_NEAR(e(1.0 - 1e-7), e(1.0), 1e-6);
    EXPECT_NEAR(e(1.0 + 1e-7), e(1.0), 1e-6);
    EXPECT_DOUBLE_EQ(e(0.0), 1.0);
  }
}

TEST(ContactLaw, HuntCrossleyRestitutionSolvesItsImplicitEquation) {
  for (const double x : {1e-6, 9e-5, 1.1e-4, 0.01, 0.3, 1.0, 10.0}) {
    const double e = hunt_crossley_restitution(x);
    ASSERT_GT(e, 0.0);
    ASSERT_LT(e, 1.0);
    // Both sides near x^2/2: cancellation leaves about 1e-16 x/x^2.
    EXPECT_NEAR((-e * x - std::log1p(-e * x)) / (x - std::log1p(x)), 1.0, 1e-8) << x;
  }
  EXPECT_DOUBLE_EQ(hunt_crossley_restitution(0.0), 1.0);
  // However fast it comes, it leaves at most with k l/c: e x -> 1.
  EXPECT_NEAR(1e3 * hunt_crossley_restitution(1e3), 1.0, 1e-12);
}

TEST(ContactLaw, ForceFollowsEachLaw) {
  const double k = 1e5, c = 100.0, g = 2e-4;
  EXPECT_DOUBLE_EQ(contact_force({ContactLaw::approach, k, c}, g, 0.1), k * g + c * 0.1);
  EXPECT_DOUBLE_EQ(contact_force({ContactLaw::approach, k, c}, g, -0.1), k * g);
  EXPECT_DOUBLE_EQ(contact_force({ContactLaw::no_adhesion, k, c}, g, -0.1), k * g - c * 0.1);
  EXPECT_DOUBLE_EQ(contact_force({ContactLaw::no_adhesion, k, c}, g, -1.0), 0.0);
  EXPECT_DOUBLE_EQ(contact_force({ContactLaw::hunt_crossley, k, c, 4e-4}, g, 0.1), k * g + c * 0.5 * 0.1);
  for (const ContactLaw kind : {ContactLaw::approach, ContactLaw::no_adhesion, ContactLaw::hunt_crossley}) {
    EXPECT_EQ(contact_force({kind, k, c}, -1e-9, 1.0), 0.0);  // no force across an open gap
  }
}

TEST(ContactLaw, SceneContactBringsItsGapAsDampingLength) {
  Contact contact{"wire", "band", 1.5e-4, 1e5, 100.0, ContactLaw::hunt_crossley};
  EXPECT_EQ(contact_force_law(contact).damping_length, 1.5e-4);
}

TEST(ContactLaw, RefusesWhatCannotBe) {
  const Contact sound{"wire", "band", 1.5e-4, 1e5, 100.0, ContactLaw::approach};
  const std::function<void(Contact&)> faults[] = {[](Contact& c) { c.gap = 0.0; },
                                                  [](Contact& c) { c.gap = NAN; },
                                                  [](Contact& c) { c.stiffness = 0.0; },
                                                  [](Contact& c) { c.stiffness = INFINITY; },
                                                  [](Contact& c) { c.damping = -1.0; },
                                                  [](Contact& c) { c.damping = NAN; },
                                                  [](Contact& c) {
                                                    c.law = ContactLaw::hard_stop;
                                                    c.restitution = 1.1;
                                                  },
                                                  [](Contact& c) {
                                                    c.law = ContactLaw::hard_stop;
                                                    c.restitution = NAN;
                                                  }};
  EXPECT_NO_THROW(contact_force_law(sound));
  for (const auto& fault : faults) {
    Contact contact = sound;
    fault(contact);
    EXPECT_THROW(contact_force_law(contact), Error);
  }
  EXPECT_THROW(approach_restitution(-0.1), Error);
  EXPECT_THROW(no_adhesion_restitution(-0.1), Error);
  EXPECT_THROW(hunt_crossley_restitution(-0.1), Error);
}

}  // namespace
}  // namespace struna::fem
