#include "apps/limit_penalty.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "fem/contact_law.hpp"
#include "fem/simulation.hpp"

namespace struna::apps {
namespace {

constexpr double wire_length = 0.5, wire_diameter = 0.0032, wire_density = 7650.0, wire_modulus = 120e9;
constexpr int wire_elements = 12;
constexpr double gap = 1e-4;                     ///< [m]
constexpr double displacement_tolerance = 0.25;  ///< 2 dB; stated in docs/limits.md
constexpr double rigid = 50.0;  ///< the hard stop's spring in lasting contacts, over a node's

double node_stiffness() {
  const double l = wire_length / wire_elements;
  return 192.0 * wire_modulus * fem::solid_circle(wire_diameter).second_moment / (8.0 * l * l * l);
}

double node_mass() {
  return wire_density * fem::solid_circle(wire_diameter).area * wire_length / wire_elements;
}

fem::Body straight_body(const std::string& name, const fem::Section& section, double modulus, int elements) {
  fem::Body body{name, fem::straight_line({0, 0, 0}, {wire_length, 0, 0}), section, wire_density, 0.3, {}};
  body.elements = elements;
  body.material.youngs_modulus = fem::constant_law(modulus);
  body.material.rayleigh = {20.0, 2e-6};
  body.material.damping = fem::Damping::viscous;
  return body;
}

fem::Scene wire_in_tube(double acceleration, unsigned seed) {
  fem::Scene scene;
  scene.bodies = {straight_body("wire", fem::solid_circle(wire_diameter), wire_modulus, wire_elements),
                  straight_body("tube", fem::solid_circle(0.02), 2e11, 6)};
  const fem::Support start{"wire", fem::End::start};
  scene.drive =
      fem::SceneDrive{start,
                      Eigen::Vector3d::UnitY(),
                      {{"wire", fem::End::end}, {"tube", fem::End::start}, {"tube", fem::End::end}}};
  scene.measurement = fem::SceneMeasurement{fem::BodyPoint{"wire", 0.5},
                                            fem::MotionQuantity::displacement,
                                            {"displacement"},
                                            {Eigen::Vector3d::UnitY()}};
  scene.contacts = {{"wire", "tube", gap, 0.0, 0.0, fem::ContactLaw::no_adhesion}};
  fem::Simulation simulation;
  simulation.duration = 0.5;
  simulation.sample_rate = 5000.0;
  simulation.tolerance = 1e-2;
  simulation.excitation.kind = fem::Excitation::Kind::random;
  simulation.excitation.band_lo_hz = 20.0;
  simulation.excitation.band_hi_hz = 600.0;
  simulation.excitation.rms_acceleration = acceleration;
  simulation.excitation.seed = seed;
  scene.simulation = simulation;
  return scene;
}

/// A spring of `over_node` times the stiffness of a node, and a dashpot of this damping ratio with the mass
/// between two nodes.
void set_contact(fem::Contact& contact, fem::ContactLaw law, double over_node, double damping_ratio) {
  contact.law = law;
  contact.stiffness = over_node * node_stiffness();
  contact.damping = 2.0 * damping_ratio * std::sqrt(contact.stiffness * node_mass());
  contact.restitution = fem::no_adhesion_restitution(damping_ratio);
}

/// Displacement of the wire's middle relative to its supports [m].
struct Level {
  double rms, peak;
};

Level level_of(const fem::TimeResponse& response) {
  const Eigen::VectorXd relative = response.output.col(0) - response.motion;
  return {relative.norm() / std::sqrt(static_cast<double>(relative.size())), relative.cwiseAbs().maxCoeff()};
}

double distance(const Level& level, const Level& wall) {
  return std::max(std::abs(level.rms / wall.rms - 1.0), std::abs(level.peak / wall.peak - 1.0));
}

}  // namespace

LimitMap penalty_limits(const LimitRun& run) {
  LimitMap map;
  map.name = "penalty";
  map.title = "A spring for a wall";
  map.quantity = "displacement of the wire's middle (rms or peak; relative)";
  map.fails = "a soft spring lets the wire through the wall that it stands for";
  map.sign = "the deepest penetration over the gap";
  map.then = "warns";
  map.axes = {run.axis("stiffness over a node's", {1e-4, 1e-3, 1e-2, 0.1, 1, 10, rigid}),
              run.axis("acceleration [m/s^2]", {1, 2.5, 10, 40}),
              run.axis("damping ratio of a blow", {0.05, 0.5})};
  for_each_place({map.axes[1], map.axes[2]}, [&](const std::vector<double>& place) {
    for (const unsigned seed : run.draws(6)) {
      fem::Scene scene = wire_in_tube(place[0], seed);
      const fem::MotionHistory motion = fem::scene_motion(scene);
      fem::Contact& contact = scene.contacts[0];
      set_contact(contact, fem::ContactLaw::hard_stop, rigid, place[1]);
      const Level wall = level_of(fem::simulate(scene, motion));
      for (const double over_node : map.axes[0].values) {
        set_contact(contact, fem::ContactLaw::no_adhesion, over_node, place[1]);
        const fem::TimeResponse response = fem::simulate(scene, motion);
        LimitTrial trial;
        trial.at = {over_node, place[0], place[1]};
        trial.seed = seed;
        trial.error = distance(level_of(response), wall);
        trial.tolerance = displacement_tolerance;
        if (told(response.report.warnings, "to stand for a wall")) trial.flags = "soft";
        map.trials.push_back(std::move(trial));
      }
    }
  });
  return map;
}

}  // namespace struna::apps
