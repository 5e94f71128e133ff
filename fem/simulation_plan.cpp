#include "fem/simulation_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/error.hpp"
#include "fem/plane_modes.hpp"
#include "fem/stiff_contact.hpp"

namespace struna::fem {
namespace {

const std::string& body_of(const std::variant<Support, BodyPoint>& at) {
  return std::visit([](const auto& place) -> const std::string& { return place.body; }, at);
}

/// Names of the bodies that contacts join to `first`.
std::vector<std::string> joined_bodies(const Scene& scene, const std::string& first) {
  std::vector<std::string> names = {first};
  const auto known = [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (bool grown = true; grown;) {
    grown = false;
    for (const auto& contact : scene.contacts) {
      if (known(contact.inside) == known(contact.outside)) continue;
      names.push_back(known(contact.inside) ? contact.outside : contact.inside);
      grown = true;
    }
  }
  return names;
}

PlannedBody planned_body(const Scene& scene, const std::string& name, double highest_hz) {
  const Body& body = body_named(scene, name);
  MeshRequest request{.hi_hz = highest_hz, .tolerance = scene.simulation->tolerance};
  request.contact = std::any_of(scene.contacts.begin(), scene.contacts.end(), [&](const Contact& contact) {
    return contact.inside == name || contact.outside == name;
  });
  const MeshChoice mesh = choose_mesh(body, request);
  PlannedBody planned{mesh, assemble(body, mesh.elements), {}, {}, {}};
  planned.modes = solve_plane_modes(planned.model, scene.drive->direction);
  planned.drive = body_drive(scene, planned.model);
  planned.coordinates = scene.simulation->method == IntegrationMethod::modal
                            ? modal_coordinates(planned.model, planned.modes, planned.drive)
                            : nodal_coordinates(planned.model, planned.drive);
  return planned;
}

/// Radius of the solid circle with the section's radius of gyration; no less than a ring's outer radius.
double outer_radius(const Section& section) {
  return 2.0 * std::sqrt(section.second_moment / section.area);
}

/// Drops the pairs whose node lies wholly beside the outside body as drawn, such as another leg of a bent
/// wire whose normal plane happens to cut the tube: it is not in the bore and nothing could have brought it
/// there.
void drop_nodes_beside(const Contact& contact, const Body& inside, const Body& outside,
                       std::vector<ContactPair>& pairs, std::vector<std::string>& warnings) {
  const double bore = contact.gap + outer_radius(inside.section);
  const double reach = outer_radius(inside.section) + std::max(bore, outer_radius(outside.section));
  const auto is_beside = [&](const ContactPair& pair) { return pair.rest_offset.norm() > reach; };
  const auto beside = std::count_if(pairs.begin(), pairs.end(), is_beside);
  if (beside == 0) return;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& pair : pairs) {
    if (is_beside(pair)) nearest = std::min(nearest, pair.rest_offset.norm());
  }
  std::erase_if(pairs, is_beside);
  warnings.push_back(fmt::format(
      "{}: {} nodes of '{}' lie beside '{}', {:.3g} m or more from its centreline, and not in it as drawn: "
      "they cannot touch it; if they should, draw the two closer",
      contact_name(contact), beside, contact.inside, contact.outside, nearest));
}

void add_contact(const Contact& contact, int inside, int outside, double highest_hz, SimulationPlan& plan) {
  const auto& a = plan.bodies[static_cast<std::size_t>(inside)];
  const auto& b = plan.bodies[static_cast<std::size_t>(outside)];
  auto pairs = contact_pairs(a.model, b.model);
  drop_nodes_beside(contact, a.model.body, b.model.body, pairs, plan.warnings);
  if (pairs.empty()) {
    plan.warnings.push_back(
        fmt::format("{}: no free node of '{}' has '{}' around it: this contact can do nothing",
                    contact_name(contact), contact.inside, contact.outside));
  }
  double deepest = 0.0;
  for (const auto& pair : pairs) {
    deepest = std::max(deepest, pair.rest_offset.norm() - contact.gap);
    plan.points.push_back(contact_point(pair, contact, a.coordinates, b.coordinates, inside, outside));
    plan.points.back().name = fmt::format(
        "contact of '{}' in '{}'{}, {:.4g} m along '{}'", contact.inside, contact.outside,
        contact.place.empty() ? "" : " (" + contact.place + ")", pair.inside_arc_length, contact.inside);
    plan.pairs.push_back({pair, inside, outside});
    plan.contacts.push_back(&contact);
  }
  plan.overlap = std::max(plan.overlap, deepest);
  if (deepest > 0.0) {
    plan.warnings.push_back(fmt::format(
        "{}: '{}' lies {:.3g} m outside the bore of '{}' (gap {:g} m) as drawn; the run starts from their "
        "equilibrium in contact",
        contact_name(contact), contact.inside, deepest, contact.outside, contact.gap));
  }
  const auto stiffness = contact_stiffness(contact, pairs, a.model, a.modes, b.modes, highest_hz);
  refuse_rigid(contact, stiffness);
  const std::string warning = stiffness_warning(contact, stiffness);
  if (!warning.empty()) plan.warnings.push_back(warning);
  plan.fastest_contact = std::max(plan.fastest_contact, stiffness.angular_frequency);
}

}  // namespace

SimulationPlan plan_simulation(const Scene& scene, double highest_hz) {
  if (!scene.drive) throw Error("simulate: the scene needs a [drive], which tells what is shaken");
  if (!scene.measurement) throw Error("simulate: the scene needs a [measure], which tells what is read");
  if (!scene.simulation) throw Error("simulate: the scene needs a [simulation] with duration and excitation");
  SimulationPlan plan;
  const auto names = joined_bodies(scene, body_of(scene.measurement->at));
  const auto index_of = [&](const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  };
  bool driven = false;
  for (const auto& name : names) {
    plan.bodies.push_back(planned_body(scene, name, highest_hz));
    driven = driven || !plan.bodies.back().drive.moved.empty() || plan.bodies.back().drive.force.size() > 0;
  }
  if (!driven) {
    throw Error(fmt::format(
        "simulate: nothing moves the measured body '{}': the drive is on '{}', and no contact joins them",
        names.front(), body_of(scene.drive->at)));
  }
  for (const auto& contact : scene.contacts) {
    const int inside = index_of(contact.inside);
    if (inside >= 0) add_contact(contact, inside, index_of(contact.outside), highest_hz, plan);
  }
  const PlannedBody& measured = plan.bodies[0];
  plan.rows = output_rows(*scene.measurement, measured.model, measured.modes, measured.coordinates,
                          measured.drive, plan.pairs, plan.measured_body);
  return plan;
}

}  // namespace struna::fem
