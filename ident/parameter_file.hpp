#pragma once

#include <string>
#include <vector>

#include "ident/doubts.hpp"
#include "ident/parameter_identification.hpp"

namespace struna::ident {

/// A law's parameters by the names that the file has, with their standard errors and units, in one line;
/// `unit` of its value, "" for none.
std::string law_text(const LawFit& fit, const std::string& unit);

/// Names of a law's parameters in the file, in the order of FrequencyLaw::parameters; none for tables.
std::vector<std::string> parameter_names(fem::FrequencyLaw::Kind kind);

/// identified.toml, see docs/files.md.
void write_parameters(const IdentifiedParameters& identified, const std::string& file,
                      const std::vector<Doubt>& doubts = {});
/// What predictions need of it: body, Rayleigh, curves and laws. Errors carry file and line.
IdentifiedParameters read_parameters(const std::string& file);

}  // namespace struna::ident
