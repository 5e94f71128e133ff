#pragma once

#include <Eigen/Core>
#include <variant>
#include <vector>

#include "fem/model.hpp"

namespace struna::fem {

/// Supports of the body moved together by the same translation U along a unit vector.
struct SupportMotion {
  std::vector<End> ends;
  Eigen::Vector3d direction;
};
/// A force at a fraction (0..1) of the arc length along a unit vector.
struct PointForce {
  double fraction = 0.5;
  Eigen::Vector3d direction;
};
using Drive = std::variant<SupportMotion, PointForce>;

/// Force that the support at `end` exerts on the body.
struct SupportForce {
  End end = End::end;
};
/// Displacement at a fraction of the arc length.
struct PointDisplacement {
  double fraction = 0.5;
};
struct Measurement {
  std::variant<SupportForce, PointDisplacement> what;
  std::vector<Eigen::Vector3d> directions;  ///< unit vectors, one output each
  /// The direction of the drive under which each output is read, where several references are taken one after
  /// the other; empty: the drive's own for all.
  std::vector<Eigen::Vector3d> drive_directions = {};
};

/// The outputs that are read under one direction of the drive.
struct Reference {
  Drive drive;
  Measurement measurement;    ///< drive_directions empty
  std::vector<long> outputs;  ///< their places in the measurement asked of
};

/// A measurement by references, in order of first appearance. Throws Error unless there are as many drive
/// directions as directions, or none.
std::vector<Reference> references_of(const Drive& drive, const Measurement& measurement);

}  // namespace struna::fem
