#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/usage.hpp"
#include "fem/scene.hpp"
#include "ident/record.hpp"
#include "ident/spectra.hpp"
#include "ident/transfer_function.hpp"

namespace struna::apps {

/// What a record says over frequency. Its first channel is the motion (or force) that drives.
struct RecordTransfer {
  std::vector<std::string> at_rest;         ///< outputs that never move: left out of all the rest
  ident::Spectra spectra;                   ///< Welch's, Hann: for densities
  Band band;                                ///< where there is excitation [Hz]; 0, 0: at single lines only
  ident::TransferFunction function;         ///< H1 over the band: the best linear approximation
  ident::TransferFunction amplitude_ratio;  ///< sqrt(S_yy/S_xx): shows what contact adds by itself; empty for
                                            ///< a sweep, where one segment makes it |H1|
};

/// `band` as from excited_band().
RecordTransfer record_transfer(const ident::Record& record, const Band& band);

/// The scene's excitation band [Hz]; of a record's motion, the lines between the first and the last at which
/// the density of the acceleration (or of the force, for a driven point) reaches a tenth of its largest.
/// 0, 0 for a sine.
Band excited_band(const fem::Scene& scene, const ident::Record& record);

/// The harmonic response without contact on positive lines, in the damping that acts in time. Nothing where
/// drive and measurement are on different bodies: then there is no path without contact.
std::optional<ident::TransferFunction> without_contact(const fem::Scene& scene,
                                                       const Eigen::VectorXd& frequency_hz);

}  // namespace struna::apps
