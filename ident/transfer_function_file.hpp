#pragma once

#include <string>
#include <vector>

#include "ident/transfer_function.hpp"

namespace struna::ident {

/// CSV: frequency [Hz], then per output NAME_re [U], NAME_im [U] and, where known, NAME_coherence [-],
/// NAME_sigma [U]; a last column `exponential_decay [1/s]`, the same in every row, where an exponential
/// window was used; likewise `leakage [Hz]` where it is known (TransferFunction). Bare re, im (coherence,
/// sigma) columns are one output named "output". Other columns are ignored. Errors carry file and line:
/// missing re, im or frequency, units that differ between them, frequencies that do not increase, coherence
/// outside [0, 1], negative sigma. `warnings` receives one line for each unit that is not understood (kind
/// unknown, carried through).
TransferFunction read_transfer_function(const std::string& file,
                                        std::vector<std::string>* warnings = nullptr);

/// Thirteen digits for the function, nine for coherence and sigma; atomic (see atomic_file.hpp). Throws Error
/// for values that are not finite.
void write_transfer_function(const TransferFunction& tf, const std::string& file);

}  // namespace struna::ident
