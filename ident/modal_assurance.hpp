#pragma once

#include <Eigen/Core>

namespace struna::ident {

/// |a^H b|^2/(|a|^2 |b|^2), 0 to 1: one where a and b are parallel, whatever their lengths and phases
/// (Allemang & Brown, Proc. 1st Int. Modal Analysis Conf. (1982) 110). Vectors of one length; NaN where one
/// vanishes.
double modal_assurance(const Eigen::VectorXcd& a, const Eigen::VectorXcd& b);

}  // namespace struna::ident
