#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/simulated_transfer.hpp"
#include "fem/simulation.hpp"
#include "ident/parameter_identification.hpp"
#include "ident/record.hpp"
#include "ident/record_comparison.hpp"
#include "ident/transfer_function.hpp"

namespace struna::apps {

/// A measured record beside the simulation that its motion drove.
struct MeasuredBeside {
  std::string file;
  ident::Record record;  ///< motion and the simulated outputs that it has
  RecordTransfer transfer;
  ident::RecordComparison comparison;
};

/// Everything the page of a simulation shows.
struct SimulationReportContent {
  std::string title;
  std::string command;  ///< how to reproduce it
  ident::Provenance provenance;
  std::vector<std::pair<std::string, std::string>> chosen;       ///< what the program chose and found
  std::vector<std::pair<std::string, std::string>> input_files;  ///< name and text
  ident::Record record;                                          ///< as written
  Eigen::VectorXd base_acceleration;                             ///< [m/s^2], per sample; empty: not a motion
  fem::SimulationReport report;
  std::vector<fem::ContactMap> contacts;
  double highest_hz = 0.0;  ///< where the record's spectra end: the anti-alias filter or Nyquist
  RecordTransfer transfer;
  std::optional<ident::TransferFunction> linear;  ///< without contact, on the lines of transfer.function
  std::optional<ident::TransferFunction> linear_at_spectra;  ///< and on those of transfer.spectra > 0
  std::optional<MeasuredBeside> measured;
};

/// One self-contained HTML page that opens offline. Long records are shown as the least and the largest value
/// of each of some thousand time bins, and the liveliest moment in every sample.
std::string render_simulation_report(const SimulationReportContent& content);

}  // namespace struna::apps
