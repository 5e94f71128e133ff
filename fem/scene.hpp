#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "fem/body.hpp"
#include "fem/harmonic.hpp"

namespace struna::fem {

/// A support of a body: "wire.start".
struct Support {
  std::string body;
  End end = End::start;
};
/// A point of a body: "wire@0.5".
struct BodyPoint {
  std::string body;
  double fraction = 0.5;
};

enum class MotionQuantity { displacement, velocity, acceleration };

struct SceneDrive {
  std::variant<Support, BodyPoint> at;  ///< a support's motion, or a force at a point
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();
  std::vector<Support> also;  ///< further supports that move with it
  /// Unit vectors by name, of references taken one after the other; x, y and z need no entry.
  std::map<std::string, Eigen::Vector3d> references = {};
};

/// What parts an output's name from that of the reference under which it was read: "force_y@z".
inline constexpr char reference_mark = '@';

struct SceneMeasurement {
  std::variant<Support, BodyPoint> at;                     ///< force at a support, or motion at a point
  MotionQuantity quantity = MotionQuantity::displacement;  ///< of a point
  std::vector<std::string> names;  ///< of the outputs: "force_x", …, or "displacement_x", …
  std::vector<Eigen::Vector3d> directions;
  std::vector<Eigen::Vector3d> drive_directions = {};  ///< see Measurement; from select_outputs
};

enum class ContactLaw { approach, no_adhesion, hunt_crossley, hard_stop };

struct Contact {
  std::string inside;
  std::string outside;
  double gap = 0.0;        ///< radial [m]
  double stiffness = 0.0;  ///< [N/m]
  double damping = 0.0;    ///< [N s/m]
  ContactLaw law = ContactLaw::approach;
  double restitution = 1.0;  ///< hard_stop only, 0..1
  std::string place = {};    ///< "FILE:LINE" of the scene file that asks for it; empty: made by a program
};

struct Excitation {
  enum class Kind { random, multisine, chirp, sine, record };
  Kind kind = Kind::random;
  double band_lo_hz = 0.0;
  double band_hi_hz = 0.0;
  double frequency_hz = 0.0;      ///< sine
  double acceleration = 0.0;      ///< amplitude, chirp and sine [m/s^2]
  double rms_acceleration = 0.0;  ///< random and multisine [m/s^2]
  unsigned seed = 1;
  std::string file;  ///< record
  std::string column;
};

enum class IntegrationMethod { modal, newmark };

struct Simulation {
  double duration = 0.0;  ///< [s]
  Excitation excitation;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  ///< [m/s^2]
  double tolerance = 1e-3;
  double step = 0.0;  ///< [s]; 0: from the tolerance
  std::optional<int> contact_substeps;  ///< parts of a fixed step while in contact; 5 where not given
  IntegrationMethod method = IntegrationMethod::modal;
  double sample_rate = 10000.0;  ///< [Hz] of the records written
};

/// Everything a scene file says.
struct Scene {
  std::vector<Body> bodies;
  std::optional<SceneDrive> drive;
  std::optional<SceneMeasurement> measurement;
  std::vector<Contact> contacts;
  std::optional<Simulation> simulation;
  double tolerance = 0.0;  ///< of what is computed from it (docs/sizing.md); 0: left to the task
};

/// The body of that name; throws Error that tells the bodies there are.
const Body& body_named(const Scene& scene, const std::string& name);

/// The body that is both driven and measured, with drive and measurement in its own terms. Without contact, a
/// scene's linear response is this body's alone. Throws Error when drive and measurement are on different
/// bodies.
struct LinearPath {
  Body body;
  Drive drive;
  Measurement measurement;
};
LinearPath linear_path(const Scene& scene);

/// Whether the scene drives and measures this body, so that linear_path() is about it.
bool is_on_linear_path(const Scene& scene, const std::string& body);

/// Keeps of the scene's measured outputs those named, in this order (that of a measured transfer function).
/// NAME@REFERENCE stands for an output read while the drive acts along that reference's direction, one of
/// drive.references or x, y, z. Throws Error that tells the outputs there are when one is not among them, or
/// the references.
void select_outputs(Scene& scene, const std::vector<std::string>& names);

}  // namespace struna::fem
