#include "fem/band_cholesky.hpp"

#include <algorithm>
#include <cmath>

namespace struna::fem {

bool BandCholesky::factorise(const BandMatrix& a, double s_a, const BandMatrix& b, double s_b) {
  lower_ = s_a * a.lower + s_b * b.lower;
  const int n = static_cast<int>(lower_.cols());
  const int width = static_cast<int>(lower_.rows()) - 1;
  for (int j = 0; j < n; ++j) {
    const double pivot = lower_(0, j);
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
    const double inverse = 1.0 / std::sqrt(pivot);
    const int reach = std::min(width, n - 1 - j);
    lower_(0, j) = inverse;
    lower_.col(j).segment(1, reach) *= inverse;
    for (int k = 1; k <= reach; ++k) {
      lower_.col(j + k).head(reach - k + 1) -= lower_(k, j) * lower_.col(j).segment(k, reach - k + 1);
    }
  }
  return true;
}

void BandCholesky::solve(Eigen::Ref<Eigen::VectorXd> x) const {
  const int n = static_cast<int>(lower_.cols());
  const int width = static_cast<int>(lower_.rows()) - 1;
  for (int j = 0; j < n; ++j) {
    const int reach = std::min(width, n - 1 - j);
    x[j] *= lower_(0, j);
    x.segment(j + 1, reach) -= x[j] * lower_.col(j).segment(1, reach);
  }
  colour(x);
}

void BandCholesky::colour(Eigen::Ref<Eigen::VectorXd> x) const {
  const int n = static_cast<int>(lower_.cols());
  const int width = static_cast<int>(lower_.rows()) - 1;
  for (int j = n - 1; j >= 0; --j) {
    const int reach = std::min(width, n - 1 - j);
    x[j] = (x[j] - lower_.col(j).segment(1, reach).dot(x.segment(j + 1, reach))) * lower_(0, j);
  }
}

}  // namespace struna::fem
