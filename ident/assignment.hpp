#pragma once

#include <Eigen/Core>
#include <vector>

namespace struna::ident {

/// The column of each row in the cheapest one-to-one assignment of rows to columns (rows <= columns, finite
/// costs): shortest augmenting paths with dual prices (Jonker & Volgenant, Computing 38 (1987) 325), rows^2
/// columns operations.
std::vector<int> cheapest_assignment(const Eigen::MatrixXd& cost);

}  // namespace struna::ident
