#pragma once

#include <vector>

#include "ident/resonance.hpp"
#include "ident/transfer_function.hpp"

namespace struna::ident {

/// The function with neighbouring lines averaged, weighted by 1/sigma^2: block b holds the lines from
/// starts[b] up to starts[b + 1]. `starts` ascending; `tf` with sigma.
TransferFunction in_blocks(const TransferFunction& tf, const std::vector<long>& starts);

/// The function with neighbouring lines averaged, weighted by 1/sigma^2, into blocks of a tenth of the
/// distance to the nearest pole: |f - f_r + i bandwidth/2|. What varies as the poles' shares do is left as it
/// is but for a thousandth (h^2/12 of a block's relative width), so a fit of the blocks starts that of all
/// lines at a cost that does not grow with their number. No block holds more than a fiftieth of the lines.
/// `tf` with sigma, lines evenly spaced.
TransferFunction in_blocks(const TransferFunction& tf, const std::vector<Pole>& poles);

}  // namespace struna::ident
