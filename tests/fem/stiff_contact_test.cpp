#include "fem/stiff_contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "fem/error.hpp"
#include "filter_scene.hpp"

namespace struna::fem {
namespace {

struct FilterContact {
  Scene scene = banded_scene(Excitation::Kind::sine, 0.03, 1e-4);
  Model wire = assemble(scene.bodies[0], 25);
  Model band = assemble(scene.bodies[1], 16);
  Eigenmodes wire_modes = solve_eigenmodes(wire);
  Eigenmodes band_modes = solve_eigenmodes(band);
  std::vector<ContactPair> pairs = contact_pairs(wire, band);

  ContactStiffness judge(const Contact& contact) const {
    return contact_stiffness(contact, pairs, wire, wire_modes, band_modes, 1000.0);
  }
};

/// w . M^-1 w over the free degrees of freedom.
double inverse_mass(const Model& model, const Eigen::VectorXd& w) {
  const auto n = static_cast<long>(model.free_dof.size());
  Eigen::MatrixXd mass(n, n);
  Eigen::VectorXd free(n);
  for (long j = 0; j < n; ++j) {
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(model.dof_count());
    unit[model.free_dof[static_cast<std::size_t>(j)]] = 1.0;
    const Eigen::VectorXd column = multiply(model.mass, unit);
    mass.col(j) = column(model.free_dof);
    free[j] = w[model.free_dof[static_cast<std::size_t>(j)]];
  }
  return free.dot(mass.partialPivLu().solve(free));
}

TEST(StiffContact, MassIsThatOfTheMassMatrices) {
  FilterContact filter;
  filter.pairs = {filter.pairs[filter.pairs.size() / 2]};
  Contact contact = filter.scene.contacts[0];
  contact.stiffness = 1e7;
  const ContactStiffness found = filter.judge(contact);
  const double per_mass = inverse_mass(filter.wire, filter.pairs[0].inside_weights.col(0)) +
                          inverse_mass(filter.band, filter.pairs[0].outside_weights.col(0));
  // The modes are complete: rounding of the eigenvalue solver.
  EXPECT_NEAR(found.angular_frequency, std::sqrt(1e7 * per_mass), 1e-6 * found.angular_frequency);
  const double ratio = 0.5 * contact.damping * std::sqrt(per_mass / 1e7);
  EXPECT_NEAR(found.restitution, approach_restitution(ratio), 1e-9);
  const double element = 0.501 / 25.0;
  EXPECT_NEAR(found.between_nodes, 192.0 * 100e9 * 3.1083e-12 / std::pow(2.0 * element, 3),
              1e-9 * found.between_nodes);
}

TEST(StiffContact, BeyondTheLimitEveryLawIsRefusedWithItsPlaceAndTheCure) {
  const FilterContact filter;
  Contact contact = filter.scene.contacts[0];
  contact.place = "s.toml:7";
  const double limit = rigid_contact * filter.judge(contact).between_nodes;
  for (const ContactLaw law :
       {ContactLaw::approach, ContactLaw::no_adhesion, ContactLaw::hunt_crossley, ContactLaw::hard_stop}) {
    contact.law = law;
    contact.stiffness = 0.99 * limit;
    EXPECT_NO_THROW(refuse_rigid(contact, filter.judge(contact)));
    EXPECT_EQ(stiffness_warning(contact, filter.judge(contact)).rfind("s.toml:7: ", 0), 0U);
    contact.stiffness = 1.01 * limit;
    try {
      refuse_rigid(contact, filter.judge(contact));
      FAIL() << "not refused";
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.rfind("s.toml:7: contact of 'wire' in 'band': ", 0), 0U) << message;
      EXPECT_NE(message.find("hard_stop"), std::string::npos) << message;
      EXPECT_EQ(message.find("restitution") != std::string::npos, law != ContactLaw::hard_stop) << message;
    }
    contact.stiffness = 0.99 * stiff_contact / rigid_contact * limit;
    EXPECT_EQ(stiffness_warning(contact, filter.judge(contact)), "");
  }
}

TEST(StiffContact, BothMethodsRefuseBeforeTheRun) {
  auto scene = banded_scene(Excitation::Kind::sine, 0.03, 1e-4);
  scene.contacts[0].stiffness = 1e12;
  for (const auto method : {IntegrationMethod::modal, IntegrationMethod::newmark}) {
    scene.simulation->method = method;
    int calls = 0;
    const auto progress = [&](double) { return ++calls > 0; };
    EXPECT_THROW(simulate(scene, scene_motion(scene), progress), Error);
    EXPECT_EQ(calls, 0);
  }
}

TEST(StiffContact, WarningsOfThePlanAreToldBeforeTheFirstStep) {
  auto scene = banded_scene(Excitation::Kind::sine, 0.03, 1e-4);
  scene.contacts[0].stiffness = 1e8;
  scene.simulation->contact_substeps = 5;
  std::vector<std::string> told;
  std::size_t before = 0;
  bool started = false;
  const auto response = simulate(
      scene, scene_motion(scene),
      [&](double) {
        if (!started) before = told.size();
        started = true;
        return false;  // one look is enough
      },
      [&](const std::string& warning) { told.push_back(warning); });
  EXPECT_EQ(told, response.report.warnings);
  ASSERT_EQ(before, 2U);
  EXPECT_NE(told[0].find("rigid stop"), std::string::npos);
  EXPECT_NE(told[1].find("contact_substeps does nothing"), std::string::npos);
}

TEST(StiffContact, NewmarkTellsThatItsStepsDoNotResolveTheBlows) {
  auto scene = banded_scene(Excitation::Kind::sine, 0.03, 1e-4);
  scene.simulation->method = IntegrationMethod::newmark;
  scene.simulation->duration = 0.006;
  scene.simulation->excitation.frequency_hz = 100.0;
  scene.simulation->excitation.acceleration = 400.0;  // 1 mm: through the gap in 2 ms
  const auto told = [&] {
    for (const auto& warning : simulated(scene).report.warnings) {
      if (warning.find("blows are not resolved") != std::string::npos) return true;
    }
    return false;
  };
  EXPECT_FALSE(told());  // 1e5 N/m swings at some 1e4 1/s: 0.02 rad in 2 us
  scene.contacts[0].stiffness = 1e8;
  EXPECT_TRUE(told());
}

TEST(StiffContact, ModalTellsThatAFixedStepIsLongForABlow) {
  auto scene = banded_scene(Excitation::Kind::sine, 0.03, 1e-4);
  scene.simulation->step = 1e-4;  // in contact a fifth
  scene.simulation->duration = 0.006;
  scene.simulation->excitation.frequency_hz = 100.0;
  scene.simulation->excitation.acceleration = 400.0;
  const auto told = [&] {
    for (const auto& warning : simulated(scene).report.warnings) {
      if (warning.find("blows are not resolved") != std::string::npos) return true;
    }
    return false;
  };
  EXPECT_FALSE(told());  // 0.2 rad in 20 us
  scene.contacts[0].stiffness = 1e8;
  EXPECT_TRUE(told());
  scene.simulation->step = 1e-6;
  EXPECT_FALSE(told());
}

}  // namespace
}  // namespace struna::fem
