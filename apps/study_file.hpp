#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/usage.hpp"
#include "ident/mode_identification.hpp"
#include "ident/parameter_identification.hpp"
#include "ident/transfer_estimate.hpp"

namespace struna::apps {

/// [transfer]: what `struna frf` takes.
struct TransferSettings {
  ident::EstimateMethod method = ident::EstimateMethod::automatic;
  ident::Estimator estimator = ident::Estimator::h1;  ///< Welch's ratio
  ident::WelchOptions welch;
  std::optional<ident::FrfKind> form;  ///< none: as measured
  std::optional<Band> band;            ///< none: every line above 0 Hz
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
  Band compare;  ///< [compare]; 0:0 the whole band
};

/// Reads study TOML (docs/files.md). Every fault is an Error with file and line.
Study read_study(const std::string& file);

}  // namespace struna::apps
