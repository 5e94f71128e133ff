#include "apps/scene_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "apps/body_table.hpp"
#include "apps/console.hpp"
#include "apps/scene_warnings.hpp"
#include "apps/toml_table.hpp"
#include "ident/parameter_file.hpp"

namespace struna::apps {
namespace {

using Place = std::variant<fem::Support, fem::BodyPoint>;

// --- places and directions
// --------------------------------------------------------------------------------------------

const fem::Body& known_body(const TomlTable& table, const std::string& key, const fem::Scene& scene,
                            const std::string& name) {
  try {
    return fem::body_named(scene, name);
  } catch (const Error& fault) {
    throw table.error(key, std::string("is on a body that is not in the scene: ") + fault.reason());
  }
}

/// "wire.start", "wire.end".
fem::Support parse_support(const TomlTable& table, const std::string& key, const fem::Scene& scene,
                           const std::string& text) {
  const std::size_t dot = text.rfind('.');
  const std::string end = dot == std::string::npos ? "" : text.substr(dot + 1);
  if (end != "start" && end != "end") {
    throw table.error(key, "must be BODY.start or BODY.end, got '" + text + "'");
  }
  const fem::Body& body = known_body(table, key, scene, text.substr(0, dot));
  const fem::Support support{body.name, end == "start" ? fem::End::start : fem::End::end};
  if ((support.end == fem::End::start ? body.start : body.end) == fem::EndCondition::free) {
    throw table.error(key, "'" + text + "' is a free end, not a support: make it clamped or pinned");
  }
  return support;
}

/// "wire@0.5".
fem::BodyPoint parse_point(const TomlTable& table, const std::string& key, const fem::Scene& scene,
                           const std::string& text) {
  const std::size_t at = text.rfind('@');
  double fraction = -1.0;
  if (at != std::string::npos) {
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + at + 1, end, fraction);
    if (read.ec != std::errc() || read.ptr != end) fraction = -1.0;
  }
  if (!(fraction >= 0.0 && fraction <= 1.0)) {
    throw table.error(
        key, "must be BODY@FRACTION with a fraction of the arc length from 0 to 1, got '" + text + "'");
  }
  return {known_body(table, key, scene, text.substr(0, at)).name, fraction};
}

Place read_place(TomlTable& table, const fem::Scene& scene) {
  if (table.has("support") && table.has("point")) {
    throw table.error("point", "contradicts support: give one of the two");
  }
  if (table.has("support")) return parse_support(table, "support", scene, table.text("support"));
  if (table.has("point")) return parse_point(table, "point", scene, table.text("point"));
  throw table.error("needs support = \"BODY.start\" or point = \"BODY@FRACTION\"");
}

/// "x", "y", "z" for the axes, else the place in the list, from 1.
std::string direction_name(const Eigen::Vector3d& direction, std::size_t index) {
  for (int axis = 0; axis < 3; ++axis) {
    if (direction == Eigen::Vector3d(Eigen::Vector3d::Unit(axis))) return {"xyz"[axis]};
  }
  return std::to_string(index + 1);
}

// --- drive, measure, contact
// --------------------------------------------------------------------------------------------

fem::SceneDrive read_drive(TomlTable table, const fem::Scene& scene) {
  fem::SceneDrive drive;
  drive.at = read_place(table, scene);
  drive.direction = table.direction("direction", table.required("direction"));
  if (table.has("references")) {
    TomlTable references = table.table("references");
    for (const std::string& name : references.keys())
      drive.references[name] = references.direction(name, references.required(name));
    references.finish();
  }
  if (table.has("also")) {
    if (std::holds_alternative<fem::BodyPoint>(drive.at)) {
      throw table.error("also", "names supports that move along: it goes with support, not with point");
    }
    std::set<std::string> seen = {table.text("support")};
    for (const auto& text : table.texts("also")) {
      drive.also.push_back(parse_support(table, "also", scene, text));
      if (!seen.insert(text).second) throw table.error("also", "names '" + text + "' a second time");
    }
  }
  table.finish();
  return drive;
}

fem::SceneMeasurement read_measurement(TomlTable table, const fem::Scene& scene) {
  fem::SceneMeasurement measurement;
  measurement.at = read_place(table, scene);
  const bool at_point = std::holds_alternative<fem::BodyPoint>(measurement.at);
  std::string quantity = "force";
  if (at_point) {
    quantity = table.text("quantity", "displacement");
    measurement.quantity =
        table.choice<fem::MotionQuantity>("quantity",
                                          {{"displacement", fem::MotionQuantity::displacement},
                                           {"velocity", fem::MotionQuantity::velocity},
                                           {"acceleration", fem::MotionQuantity::acceleration}},
                                          fem::MotionQuantity::displacement);
  } else if (table.has("quantity")) {
    throw table.error("quantity", "goes with point; at a support the force is read");
  }
  const toml::array* directions = table.required("directions").as_array();
  if (directions == nullptr || directions->empty()) {
    throw table.error("directions", "must be an array of \"x\", \"y\", \"z\" or vectors, with at least one");
  }
  for (const auto& entry : *directions) {
    const Eigen::Vector3d direction = table.direction("directions", entry);
    const std::string name = quantity + "_" + direction_name(direction, measurement.names.size());
    if (std::count(measurement.names.begin(), measurement.names.end(), name) > 0) {
      throw table.error("directions", entry, "gives the output " + name + " a second time");
    }
    measurement.names.push_back(name);
    measurement.directions.push_back(direction);
  }
  table.finish();
  return measurement;
}

fem::Contact read_contact(TomlTable& table, const fem::Scene& scene) {
  fem::Contact contact;
  contact.inside = known_body(table, "inside", scene, table.text("inside")).name;
  contact.outside = known_body(table, "outside", scene, table.text("outside")).name;
  if (contact.inside == contact.outside) {
    throw table.error("outside", "must be another body than inside, got '" + contact.outside + "' for both");
  }
  for (const auto& other : scene.contacts) {
    if (other.inside == contact.inside && other.outside == contact.outside) {
      throw table.error("outside", "repeats the contact of '" + contact.inside + "' and '" + contact.outside +
                                       "' above; give it once");
    }
  }
  contact.gap = table.positive("gap");
  contact.place = table.place();
  if (!table.has("stiffness")) {
    throw table.error("stiffness", "is missing and must be given" + table.misspelling_of("stiffness") +
                                       "; how hard the wall is in N/m: 1e5 for a rubber band, 1e6 and more "
                                       "for metal, for a wall that does not give law = \"hard_stop\" "
                                       "(its lasting contacts need a stiffness, 1e6 say)");
  }
  contact.stiffness = table.positive("stiffness");
  contact.damping = table.not_negative("damping", 0.0);
  contact.law = table.choice<fem::ContactLaw>("law",
                                              {{"approach", fem::ContactLaw::approach},
                                               {"no_adhesion", fem::ContactLaw::no_adhesion},
                                               {"hunt_crossley", fem::ContactLaw::hunt_crossley},
                                               {"hard_stop", fem::ContactLaw::hard_stop}},
                                              fem::ContactLaw::approach);
  if (contact.law == fem::ContactLaw::hard_stop) {
    contact.restitution = table.not_negative("restitution", contact.restitution);
    if (contact.restitution > 1.0) {
      throw table.error("restitution", fmt::format("must be between 0 and 1, got {}", contact.restitution));
    }
  } else if (table.has("restitution")) {
    throw table.error("restitution",
                      "belongs to law = \"hard_stop\"; the other laws rebound as their damping says");
  }
  table.finish();
  return contact;
}

// --- simulation
// -----------------------------------------------------------------------------------------------------------

void read_excitation_band(TomlTable& table, fem::Excitation& excitation, double nyquist_hz) {
  const Band band = table.band("band");
  if (band.lo_hz <= 0.0) {
    throw table.error("band",
                      "must begin above 0 Hz, where an acceleration would mean a displacement without limit");
  }
  if (band.hi_hz >= nyquist_hz) {
    throw table.error(
        "band", fmt::format("must end below half the sample_rate = {} Hz, got {}", nyquist_hz, band.hi_hz));
  }
  excitation.band_lo_hz = band.lo_hz;
  excitation.band_hi_hz = band.hi_hz;
}

fem::Excitation read_excitation(TomlTable table, double nyquist_hz) {
  using Kind = fem::Excitation::Kind;
  fem::Excitation excitation;
  table.required("kind");
  excitation.kind = table.choice<Kind>("kind", {{"random", Kind::random},
                                                {"multisine", Kind::multisine},
                                                {"chirp", Kind::chirp},
                                                {"sine", Kind::sine},
                                                {"record", Kind::record}});
  switch (excitation.kind) {
    case Kind::random:
    case Kind::multisine: {
      read_excitation_band(table, excitation, nyquist_hz);
      excitation.rms_acceleration = table.positive("rms_acceleration");
      const int seed = table.integer("seed", 1);
      if (seed < 0) throw table.error("seed", fmt::format("must be >= 0, got {}", seed));
      excitation.seed = static_cast<unsigned>(seed);
      break;
    }
    case Kind::chirp:
      read_excitation_band(table, excitation, nyquist_hz);
      excitation.acceleration = table.positive("acceleration");
      break;
    case Kind::sine:
      excitation.frequency_hz = table.positive("frequency");
      if (excitation.frequency_hz >= nyquist_hz) {
        throw table.error("frequency", fmt::format("must be below half the sample_rate = {} Hz, got {}",
                                                   nyquist_hz, excitation.frequency_hz));
      }
      excitation.acceleration = table.positive("acceleration");
      break;
    case Kind::record:
      excitation.file = table.path("file");
      excitation.column = table.text("column");
      break;
  }
  table.finish();
  return excitation;
}

fem::Simulation read_simulation(TomlTable table, double tolerance) {
  fem::Simulation simulation;
  if (tolerance > 0.0) simulation.tolerance = tolerance;
  simulation.duration = table.positive("duration");
  simulation.sample_rate = table.positive("sample_rate", simulation.sample_rate);
  simulation.excitation = read_excitation(table.table("excitation"), 0.5 * simulation.sample_rate);
  if (table.has("gravity")) simulation.gravity = table.vector3("gravity");
  simulation.tolerance = table.positive("tolerance", simulation.tolerance);
  if (simulation.tolerance >= 1.0) {
    throw table.error("tolerance", fmt::format("is a fraction of the largest displacement, below 1, got {}",
                                               simulation.tolerance));
  }
  simulation.step = table.positive("step", simulation.step);
  if (table.has("contact_substeps")) {
    simulation.contact_substeps = table.integer("contact_substeps", 0);
    if (*simulation.contact_substeps < 1) {
      throw table.error("contact_substeps",
                        fmt::format("must be at least 1, got {}", *simulation.contact_substeps));
    }
  }
  simulation.method = table.choice<fem::IntegrationMethod>(
      "method", {{"modal", fem::IntegrationMethod::modal}, {"newmark", fem::IntegrationMethod::newmark}},
      simulation.method);
  table.finish();
  return simulation;
}

}  // namespace

fem::Scene read_scene(const std::string& file) {
  ToldScene read = read_told_scene(file);
  for (const Notice& notice : read.told)
    if (notice.matters) print(notice.text);
  return read.scene;
}

ToldScene read_told_scene(const std::string& file) {
  const toml::table content = parse_toml(file);
  TomlTable root(content, file);
  ToldScene result;
  fem::Scene& scene = result.scene;
  scene.tolerance = root.positive("tolerance", 0.0);
  if (scene.tolerance >= 1.0) {
    throw root.error("tolerance", fmt::format("is a fraction, below 1, got {}", scene.tolerance));
  }
  for (TomlTable& body : root.tables("body"))
    scene.bodies.push_back(read_body(body, scene, root.has("simulation"), result.told));
  if (scene.bodies.empty()) throw Error(file, 0, "has no [[body]]: a scene needs at least one");
  if (root.has("drive")) scene.drive = read_drive(root.table("drive"), scene);
  if (root.has("measure")) scene.measurement = read_measurement(root.table("measure"), scene);
  for (TomlTable& contact : root.tables("contact")) scene.contacts.push_back(read_contact(contact, scene));
  if (root.has("simulation")) scene.simulation = read_simulation(root.table("simulation"), scene.tolerance);
  root.finish();
  for (const std::string& warning : scene_warnings(scene)) warn(file + ": " + warning);
  return result;
}

void apply_parameters(fem::Scene& scene, const std::vector<std::string>& parameter_files) {
  std::set<std::string> done;
  for (const auto& file : parameter_files) {
    const ident::IdentifiedParameters identified = ident::read_parameters(file);
    if (!done.insert(identified.body).second) {
      throw Error(file, 0,
                  "is a second parameter file for body '" + identified.body + "'; give one for each body");
    }
    const auto body = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                   [&](const fem::Body& other) { return other.name == identified.body; });
    if (body == scene.bodies.end()) {
      std::string names;
      for (const auto& other : scene.bodies) names += (names.empty() ? "'" : ", '") + other.name + "'";
      throw Error(
          file, 0,
          "belongs to body '" + identified.body + "', which the scene does not have; it has " + names);
    }
    blaming({file}, [&] { *body = ident::apply(identified, *body); });
  }
}

bool has_modulus(const fem::Body& body) {
  const fem::FrequencyLaw& law = body.material.youngs_modulus;
  return !law.parameters.empty() || !law.value.empty();
}

void require_modulus(const fem::Body& body, const std::string& scene_file) {
  if (has_modulus(body)) return;
  throw Error(scene_file, 0,
              "body '" + body.name +
                  "' has no youngs_modulus; give it in [body.material], or identified "
                  "parameters with --parameters");
}

}  // namespace struna::apps
