#pragma once

#include <string>

#include "ident/transfer_function.hpp"

namespace struna::ident {

/// CSV: frequency [Hz], then per output NAME_re [U], NAME_im [U] and, where known, NAME_coherence [-], NAME_sigma [U].
/// Bare re, im columns are one output named "output"... Other columns are ignored. Errors carry file and line.
/// `warnings` receives one line for each unit that is not understood (kind unknown, carried through).
TransferFunction read_transfer_function(const std::string& file, std::vector<std::string>* warnings = nullptr);
void write_transfer_function(const TransferFunction& tf, const std::string& file);

}  // namespace struna::ident
