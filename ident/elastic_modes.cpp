#include "ident/elastic_modes.hpp"

#include <algorithm>
#include <cmath>

#include "fem/eigenmodes.hpp"

namespace struna::ident {

double without_mesh_error(double eigenvalue, const fem::Model& model) {
  const fem::Body& body = model.body;
  const double h = model.arc_length.back() / static_cast<double>(model.arc_length.size() - 1);
  const double b4 = body.density * body.section.area * eigenvalue / body.section.second_moment;
  // Beyond a tenth the formula no longer holds, and further on it would put modes out of order.
  return eigenvalue / std::pow(1.0 + std::min(b4 * std::pow(h, 4) / 1440.0, 0.1), 2);
}

int modes_to_solve(std::size_t measured) {
  return 4 * static_cast<int>(measured) + 20;
}

ElasticModes elastic_modes(const fem::Model& model, const fem::Drive& drive,
                           const fem::Measurement& measurement, int count) {
  const fem::Eigenmodes all = fem::solve_eigenmodes(model, count);
  ElasticModes result;
  result.rigid = static_cast<int>(fem::rigid_modes(model.body, all.eigenvalue));
  const long elastic = all.eigenvalue.size() - result.rigid;
  result.eigenmodes = {all.eigenvalue.tail(elastic), all.shape.rightCols(elastic)};
  result.modes.eigenvalue =
      result.eigenmodes.eigenvalue.unaryExpr([&](double v) { return without_mesh_error(v, model); });
  // Rounding may exchange double ones.
  std::sort(result.modes.eigenvalue.begin(), result.modes.eigenvalue.end());
  result.modes.constant =
      fem::modal_constants(model, result.eigenmodes, drive, measurement, fem::constant_law(1.0));
  result.modes.constant_scales_with_modulus = std::holds_alternative<fem::SupportMotion>(drive) ||
                                              std::holds_alternative<fem::SupportForce>(measurement.what);
  return result;
}

}  // namespace struna::ident
