#include "fem/drive.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "fem/error.hpp"

namespace struna::fem {

std::vector<Reference> references_of(const Drive& drive, const Measurement& measurement) {
  const auto& along = measurement.drive_directions;
  if (along.empty()) {
    Reference all{drive, measurement, {}};
    for (std::size_t k = 0; k < measurement.directions.size(); ++k)
      all.outputs.push_back(static_cast<long>(k));
    return {all};
  }
  if (along.size() != measurement.directions.size())
    throw Error(fmt::format("references_of: a drive direction for each of the {} outputs, got {}",
                            measurement.directions.size(), along.size()));
  std::vector<Reference> references;
  std::vector<Eigen::Vector3d> known;
  for (std::size_t k = 0; k < along.size(); ++k) {
    const auto at = std::find(known.begin(), known.end(), along[k]) - known.begin();
    if (at == static_cast<long>(known.size())) {
      known.push_back(along[k]);
      references.push_back({drive, {measurement.what, {}}, {}});
      std::visit([&](auto& driven) { driven.direction = along[k]; }, references.back().drive);
    }
    Reference& reference = references[static_cast<std::size_t>(at)];
    reference.measurement.directions.push_back(measurement.directions[k]);
    reference.outputs.push_back(static_cast<long>(k));
  }
  return references;
}

}  // namespace struna::fem
