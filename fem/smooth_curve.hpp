#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem/centreline.hpp"

namespace struna::fem {

/// A curve by states at some of its parameters t, chords summed up in units of their mean; a quintic between
/// two of them.
struct SmoothCurve {
  std::vector<double> t;               ///< from 0, increasing
  std::vector<Eigen::Matrix3d> state;  ///< columns: position [m], its first and second derivative by t
  double scatter = 0.0;                ///< standard deviation of a point's coordinate across the curve [m]

  Eigen::Vector3d at(double t) const;
};

/// What points tell of the curve that they were read off.
struct CurvesThroughPoints {
  SmoothCurve likeliest;
  std::vector<SmoothCurve> drawn;  ///< others, as likely as the points leave them
  double turn = 0.0;               ///< of the likeliest, along all of it [rad]
};

/// Smoothing of points that scatter alike across the curve, in both directions; the ends are taken as true,
/// and so is what scatters along the curve, as a point moved along it still lies on it. The curve is an arc,
/// x''' = -turn^2 x' by t, but for white noise: an integrated Wiener process (Wahba, J. R. Stat. Soc. B 40
/// (1978) 364; by states: Wecker & Ansley, J. Am. Stat. Assoc. 78 (1983) 81) about arcs, which are L-splines
/// in Kimeldorf and Wahba's sense. How rough against how scattered: restricted likelihood, with all
/// logarithms of the ratio between its bounds as likely beforehand. `draws` curves come from a fixed seed,
/// each with a ratio of equal share of the likelihood and a scatter by chi^2. Points nearer than a twentieth
/// of the mean chord count as one; at least 5 others. Throws Error on fewer.
CurvesThroughPoints curves_through(const std::vector<Eigen::Vector3d>& points, int draws);

/// The smooth curve as a centreline, of `length` [m] where that is positive.
Centreline centreline_along(const SmoothCurve& curve, double length = 0.0);

}  // namespace struna::fem
