#pragma once

#include <map>
#include <string>
#include <vector>

#include "apps/study_file.hpp"

namespace struna::apps {

/// What `struna frf` and `struna identify` make of records.
struct MeasuredTransfer {
  ident::TransferEstimate estimate;   ///< how it was made; its function over all lines, as measured
  ident::TransferFunction function;   ///< in the form and band asked for
  std::vector<std::string> warnings;  ///< what a user should look at, a line each
};

MeasuredTransfer measure_transfer(const std::vector<std::string>& records, const std::string& input,
                                  const std::vector<std::string>& outputs,
                                  const std::map<std::string, ident::ChannelCorrection>& corrections,
                                  const TransferSettings& settings);

/// An estimate in the form and band asked for, with what a user should look at.
MeasuredTransfer examined(ident::TransferEstimate estimate, const TransferSettings& settings);

/// What the settings make of an estimated function.
ident::TransferFunction in_band_and_form(ident::TransferFunction function, const TransferSettings& settings);

/// How the function was made: estimator and why, resolution, segments, averages, window, band … as name and
/// value.
std::vector<std::pair<std::string, std::string>> transfer_settings_shown(const MeasuredTransfer& measured);

}  // namespace struna::apps
