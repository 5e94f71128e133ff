#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "fem/drive.hpp"

namespace struna::fem {

/// Factors of K1 and M in the dynamic stiffness at a line: (6) with (9), or (7).
struct DynamicScales {
  std::complex<double> stiffness;
  std::complex<double> mass;
};

DynamicScales dynamic_scales(const Material& material, Damping damping, double f_hz);

/// Where a body is driven or read, as a vector over all dof: the unit motion of supports (`at_support`),
/// whose force is K1 and M times it, else a unit load or the displacement of a point.
struct Terminal {
  Eigen::VectorXd vector;
  bool at_support = false;
  Eigen::VectorXd k;  ///< K1 vector, for those at a support
  Eigen::VectorXd m;  ///< M vector
};

/// Throw Error where the support is free or a direction is no unit vector.
Terminal drive_terminal(const Model& model, const Drive& drive);
std::vector<Terminal> output_terminals(const Model& model, const Measurement& measurement);

/// All of a harmonic problem that does not depend on frequency: (s_k K1 + s_m M) u = load, output = weights u
/// + direct part. Over the free dof that K1 and M join to the drive; the others stay at rest: a straight wire
/// shaken across moves in one plane and does not twist. `measurement` without drive directions of its own.
struct HarmonicProblem {
  /// A terminal's rows of K1 and M at the dof where it is at a support, else its vector there.
  struct Part {
    bool at_support = false;
    Eigen::VectorXd k;
    Eigen::VectorXd m;
    Eigen::VectorXd point;
  };
  /// The part of a drive that reaches an output without the dof moving: s_k k + s_m m + constant.
  struct Direct {
    double k = 0.0;
    double m = 0.0;
    double constant = 0.0;
  };

  HarmonicProblem(const Model& model, const Drive& drive, const Measurement& measurement);

  std::vector<int> dof;  ///< increasing; all free dof where the drive reaches none
  BandMatrix stiffness;  ///< of one bandwidth, no wider than these dof need
  BandMatrix mass;
  Part drive;
  std::vector<Part> outputs;
  std::vector<Direct> direct;  ///< of each output
};

}  // namespace struna::fem
