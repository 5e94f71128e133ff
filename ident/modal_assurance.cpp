#include "ident/modal_assurance.hpp"

#include <limits>

namespace struna::ident {

double modal_assurance(const Eigen::VectorXcd& a, const Eigen::VectorXcd& b) {
  const double scale = a.squaredNorm() * b.squaredNorm();
  return scale > 0.0 ? std::norm(a.dot(b)) / scale : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace struna::ident
