#include "fem/scene.hpp"

#include <algorithm>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

const std::string& body_of(const std::variant<Support, BodyPoint>& at) {
  return std::visit([](const auto& place) -> const std::string& { return place.body; }, at);
}

/// The ends of `body` among the driven supports, without repetition.
std::vector<End> driven_ends(const SceneDrive& drive, const std::string& body) {
  std::vector<Support> supports = drive.also;
  if (const auto* first = std::get_if<Support>(&drive.at)) supports.insert(supports.begin(), *first);
  std::vector<End> ends;
  for (const auto& support : supports) {
    const bool known = std::find(ends.begin(), ends.end(), support.end) != ends.end();
    if (support.body == body && !known) ends.push_back(support.end);
  }
  return ends;
}

/// The drive as the body feels it; none where it does not.
std::optional<Drive> drive_of(const SceneDrive& drive, const std::string& body) {
  if (const auto* point = std::get_if<BodyPoint>(&drive.at)) {
    if (point->body == body) return PointForce{point->fraction, drive.direction};
  } else if (auto ends = driven_ends(drive, body); !ends.empty()) {
    return SupportMotion{std::move(ends), drive.direction};
  }
  return std::nullopt;
}

Measurement measurement_of(const SceneMeasurement& measurement) {
  if (const auto* support = std::get_if<Support>(&measurement.at)) {
    return {SupportForce{support->end}, measurement.directions, measurement.drive_directions};
  }
  return {PointDisplacement{std::get<BodyPoint>(measurement.at).fraction}, measurement.directions,
          measurement.drive_directions};
}

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text.empty() ? "none" : text;
}

/// The drive's direction of a reference, unit.
Eigen::Vector3d reference_direction(const SceneDrive& drive, const std::string& name) {
  if (const auto given = drive.references.find(name); given != drive.references.end()) return given->second;
  if (name == "x") return Eigen::Vector3d::UnitX();
  if (name == "y") return Eigen::Vector3d::UnitY();
  if (name == "z") return Eigen::Vector3d::UnitZ();
  std::vector<std::string> known = {"x", "y", "z"};
  for (const auto& [other, direction] : drive.references) known.push_back(other);
  throw Error("the direction of reference '" + name + "' is not known; known: " + listed(known) +
              "; [drive.references] in the scene tells further ones");
}

}  // namespace

const Body& body_named(const Scene& scene, const std::string& name) {
  const auto found = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                  [&](const Body& body) { return body.name == name; });
  if (found != scene.bodies.end()) return *found;
  std::vector<std::string> names;
  for (const auto& body : scene.bodies) names.push_back(body.name);
  throw Error("no body is named '" + name + "'; there is: " + listed(names));
}

LinearPath linear_path(const Scene& scene) {
  if (!scene.drive) throw Error("linear_path: the scene needs a [drive], which tells what is shaken");
  if (!scene.measurement) throw Error("linear_path: the scene needs a [measure], which tells what is read");
  const Body& body = body_named(scene, body_of(scene.measurement->at));
  const std::optional<Drive> drive = drive_of(*scene.drive, body.name);
  if (!drive) {
    throw Error("linear_path: the measured body '" + body.name +
                "' must be driven too, but the drive is on '" + body_of(scene.drive->at) +
                "'; only contact could carry the motion across");
  }
  return {body, *drive, measurement_of(*scene.measurement)};
}

bool is_on_linear_path(const Scene& scene, const std::string& body) {
  return scene.drive && scene.measurement && body_of(scene.measurement->at) == body &&
         drive_of(*scene.drive, body).has_value();
}

void select_outputs(Scene& scene, const std::vector<std::string>& names) {
  if (!scene.measurement) throw Error("the scene needs a [measure] that tells what the outputs are");
  SceneMeasurement selected = *scene.measurement;
  selected.names.clear();
  selected.directions.clear();
  selected.drive_directions.clear();
  const auto& known = scene.measurement->names;
  bool referenced = false;
  for (const auto& name : names) {
    const auto mark = name.rfind(reference_mark);
    const auto found = std::find(known.begin(), known.end(), name.substr(0, mark));
    if (found == known.end()) {
      throw Error("output '" + name +
                  "' is not one that the scene's [measure] reads; it reads: " + listed(known));
    }
    selected.names.push_back(name);
    selected.directions.push_back(
        scene.measurement->directions[static_cast<std::size_t>(found - known.begin())]);
    if (mark != std::string::npos && !scene.drive)
      throw Error("output '" + name + "' is read under a reference: the scene needs a [drive]");
    referenced = referenced || mark != std::string::npos;
    if (scene.drive)
      selected.drive_directions.push_back(mark == std::string::npos
                                              ? scene.drive->direction
                                              : reference_direction(*scene.drive, name.substr(mark + 1)));
  }
  if (!referenced) selected.drive_directions.clear();
  scene.measurement = std::move(selected);
}

}  // namespace struna::fem
