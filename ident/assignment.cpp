#include "ident/assignment.hpp"

#include <fmt/format.h>

#include <limits>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

constexpr int none = -1;

/// Dual prices and the matching so far. Every reduced cost, cost - row price - column price, is at least
/// zero, and zero on the matching: so it is the cheapest among those of its rows.
struct Matching {
  Eigen::VectorXd row_price;
  Eigen::VectorXd column_price;
  std::vector<int> row_of;  ///< of each column
};

/// Adds `row` along the shortest path of reduced costs to a free column (Dijkstra), and moves the prices by
/// it.
void augment(const Eigen::MatrixXd& cost, int row, Matching& matching) {
  const int columns = static_cast<int>(cost.cols());
  Eigen::VectorXd distance = Eigen::VectorXd::Constant(columns, std::numeric_limits<double>::infinity());
  std::vector<int> via(static_cast<std::size_t>(columns), none);  // the column before, on the path
  std::vector<int> settled;
  std::vector<bool> is_settled(static_cast<std::size_t>(columns), false);
  int at_row = row;
  int at_column = none;
  double travelled = 0.0;
  while (true) {
    int nearest = none;
    for (int j = 0; j < columns; ++j) {
      if (is_settled[static_cast<std::size_t>(j)]) continue;
      const double length =
          travelled + cost(at_row, j) - matching.row_price[at_row] - matching.column_price[j];
      if (length < distance[j]) {
        distance[j] = length;
        via[static_cast<std::size_t>(j)] = at_column;
      }
      if (nearest == none || distance[j] < distance[nearest]) nearest = j;
    }
    travelled = distance[nearest];
    at_column = nearest;
    at_row = matching.row_of[static_cast<std::size_t>(nearest)];
    if (at_row == none) break;
    is_settled[static_cast<std::size_t>(nearest)] = true;
    settled.push_back(nearest);
  }
  matching.row_price[row] += travelled;
  for (int j : settled) {
    const double slack = travelled - distance[j];
    matching.column_price[j] -= slack;
    matching.row_price[matching.row_of[static_cast<std::size_t>(j)]] += slack;
  }
  while (at_column != none) {
    const int before = via[static_cast<std::size_t>(at_column)];
    matching.row_of[static_cast<std::size_t>(at_column)] =
        before == none ? row : matching.row_of[static_cast<std::size_t>(before)];
    at_column = before;
  }
}

}  // namespace

std::vector<int> cheapest_assignment(const Eigen::MatrixXd& cost) {
  if (cost.rows() > cost.cols() || !cost.allFinite()) {
    throw Error(fmt::format("cheapest_assignment: finite costs and no more rows than columns, got {} x {}",
                            cost.rows(), cost.cols()));
  }
  Matching matching{Eigen::VectorXd::Zero(cost.rows()), Eigen::VectorXd::Zero(cost.cols()),
                    std::vector<int>(static_cast<std::size_t>(cost.cols()), none)};
  for (int row = 0; row < cost.rows(); ++row) augment(cost, row, matching);
  std::vector<int> column_of(static_cast<std::size_t>(cost.rows()), none);
  for (int j = 0; j < cost.cols(); ++j) {
    const int row = matching.row_of[static_cast<std::size_t>(j)];
    if (row != none) column_of[static_cast<std::size_t>(row)] = j;
  }
  return column_of;
}

}  // namespace struna::ident
