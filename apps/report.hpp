#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "ident/comparison.hpp"
#include "ident/doubts.hpp"
#include "ident/mode.hpp"
#include "ident/parameter_identification.hpp"
#include "ident/transfer_function.hpp"

namespace struna::apps {

/// Everything the report shows; nothing is computed in it but what drawing needs. What is empty is left out
/// of the page.
struct ReportContent {
  std::string title;
  std::string command;  ///< how to reproduce it
  std::vector<ident::Doubt> doubts;
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::string>>
      settings;  ///< name, value: estimator, resolution, averages, …
  ident::TransferFunction measured;
  ident::TransferFunction predicted;  ///< structural damping
  ident::TransferFunction predicted_viscous;
  ident::ModeSet modes;
  ident::IdentifiedParameters identified;
  ident::Comparison comparison;  ///< against structural
  ident::Comparison comparison_viscous;

  /// Natural frequencies of the identified model [Hz], in the order of Pair::model; may be empty.
  Eigen::VectorXd model_natural_frequency_hz;
  /// Name and text of the files that the run was told by (study, scene): shown, so that the page reproduces
  /// itself.
  std::vector<std::pair<std::string, std::string>> input_files;
};

/// One self-contained HTML page (chart library embedded) that opens offline.
std::string render_report(const ReportContent& content);

}  // namespace struna::apps
