#pragma once

#include <Eigen/Core>
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
  std::string drive_signal;                  ///< column; empty: none
  std::string fixture;                       ///< transfer function of the empty run; empty: none
  std::map<std::string, double> clamp_mass;  ///< [kg], by output
  std::optional<ident::FrfKind> form;        ///< none: as measured
  std::optional<Band> band;                  ///< none: every line above 0 Hz
};

/// [[reference]]: a run with the shaker along another direction, or the study's only one.
struct StudyReference {
  std::string name;                          ///< "y"
  std::optional<Eigen::Vector3d> direction;  ///< unit; none: the scene's
  std::string input;
  std::vector<std::string> records;
};

/// Everything a study file says; paths already resolved against its folder.
struct Study {
  std::string file;
  std::string scene;
  std::vector<StudyReference> references;  ///< one without name where the study has no [[reference]]
  std::vector<std::string> records;        ///< of all references
  std::string input;                       ///< of the first reference
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
