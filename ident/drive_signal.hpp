#pragma once

#include "ident/local_model.hpp"

namespace struna::ident {

/// Transfer functions between measured signals by way of the drive signal, which causes both but is free of
/// their noise: H = G_y/G_x, G_x and G_y the functions of input and outputs over the drive signal. Noise on
/// the input, which pulls the ratio of input and output down by the input's coherence, drops out (the
/// instrumental variable of Wellstead, Automatica 17 (1981) 669; Pintelon & Schoukens, System Identification,
/// 2nd ed., 2.7).
///
/// `records`: spectra with the drive signal first, the input second, then the outputs. What disturbs input
/// and output alike, a motion that the drive did not ask for but the structure answers, is no noise of H: the
/// standard deviation follows from the power of y - H x that the drive signal does not explain. Lines at
/// which the input cannot be told from its noise (G_x below ten times its sigma) are left out. The coherence
/// is that of y with H x. Otherwise as local_model(), whose options and errors it has.
LocalModel local_model_by_drive(const std::vector<RecordSpectrum>& records, double highest_hz,
                                const LocalModelOptions& options);

}  // namespace struna::ident
