#pragma once

#include <Eigen/Core>

namespace struna::ident {

/// Where a hammer hit lies in its force record.
struct Hit {
  long start = 0;  ///< first sample of the pulse
  long peak = 0;
  bool second = false;  ///< another pulse of at least a tenth of the peak after the first has ended
};

/// The pulse is what exceeds a tenth of the largest deviation from the median (a hammer is at rest most of
/// the time), begun where the force first leaves 2 % of it or its scatter before the hit, whichever is more.
/// Throws Error for a force that is constant.
Hit find_hit(const Eigen::VectorXd& force);

/// Each column's value at rest: its mean before the hit; with fewer than 8 samples there, its median.
Eigen::RowVectorXd rest_values(const Eigen::MatrixXd& samples, const Hit& hit);

}  // namespace struna::ident
