#pragma once

#include <string>

#include "ident/parameter_identification.hpp"

namespace struna::ident {

/// identified.toml, see docs/files.md.
void write_parameters(const IdentifiedParameters& identified, const std::string& file);
/// What predictions need of it: body, Rayleigh, curves and laws (the first law only). Errors carry file and line.
IdentifiedParameters read_parameters(const std::string& file);

}  // namespace struna::ident
