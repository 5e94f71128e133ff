#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/modal_stepping.hpp"
#include "fem/pole_stepping.hpp"

namespace struna::fem {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Where a mode or a pole of the assembled system comes from.
struct ModalOrigin {
  int body = 0;
  int index = 0;
};

/// Bodies and contact points as a ModalStepper computes with them: what is never excited is left out, what is
/// left to statics is condensed, and where every point moves on a line, one component per point is kept.
///   h (dimension numbers per point) = rest + motion u + rows q + static deflection.
struct ModalSystem {
  PoleArrays poles;
  std::vector<ModalOrigin> mode_origin;  ///< per stepped mode
  std::vector<ModalOrigin> pole_origin;  ///< per stepped pole
  Eigen::ArrayX3d load;                  ///< per stepped mode, on u, u', u''
  Eigen::ArrayXd constant_load;
  Eigen::ArrayXd relaxed_stiffness;        ///< per stepped mode [1/s^2]; 0 for rigid ones
  Eigen::ArrayXd rest_stiffness;           ///< per stepped mode, of a static rest [1/s^2]; 0 for rigid ones
  std::vector<double> frequency_hz;        ///< per stepped mode; 0 for rigid ones
  std::vector<char> viscoelastic;          ///< per stepped mode: more poles than a viscous one has
  std::vector<ModalOrigin> static_origin;  ///< modes that follow statically
  Eigen::ArrayXd static_compliance;        ///< their q/p [s^2]
  Eigen::ArrayX3d static_load;             ///< on u, u', u''
  Eigen::ArrayXd static_constant_load;
  RowMatrix static_rows;

  int dimension = 2;                  ///< 1: every point moves on its line
  std::vector<Eigen::Vector2d> line;  ///< its direction in the point's plane (dimension 1)
  Eigen::VectorXd rest, motion;
  RowMatrix rows;                ///< (points x dimension) x modes
  RowMatrix static_flexibility;  ///< rows x rows [m/N], of the static modes; empty without them
  int idle_modes = 0;
};

/// Static modes deflect under their constant load and under a driving force (both are in `rest` and
/// `motion`); their inertia load is read out (displacement, internal force) but not fed to the contacts.
/// `moving` tells, per body and mode, what already moves (an initial state); modes above `highest_mode_hz`
/// (0: none) are left to statics.
ModalSystem modal_system(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                         const std::vector<std::vector<char>>& moving, double highest_mode_hz);

/// Throws Error on sizes that do not fit, values that are not finite, poles that grow.
void validate(const std::vector<ModalBody>& bodies);

}  // namespace struna::fem
