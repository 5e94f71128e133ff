#pragma once

#include <map>
#include <string>
#include <vector>

#include "ident/mode_identification.hpp"
#include "ident/parameter_identification.hpp"
#include "ident/spectra.hpp"
#include "ident/transfer_function.hpp"

namespace struna::apps {

/// [transfer]: what `struna frf` takes.
struct TransferSettings {
  ident::WelchOptions welch;
  ident::Estimator estimator = ident::Estimator::h1;
  std::string form = "as-measured";
  double band_lo_hz = 0.0;
  double band_hi_hz = 0.0;
};
struct CompareSettings {
  double band_lo_hz = 0.0;
  double band_hi_hz = 0.0;
};

/// Everything a study file says; paths already resolved against its folder.
struct Study {
  std::string file;
  std::string scene;
  std::vector<std::string> records;
  std::string input;
  std::vector<std::string> outputs;
  std::map<std::string, ident::ChannelCorrection> corrections;
  TransferSettings transfer;
  ident::ModeOptions modes;
  ident::FitOptions fit;
  CompareSettings compare;
};

Study read_study(const std::string& file);

}  // namespace struna::apps
