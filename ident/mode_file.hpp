#pragma once

#include <string>
#include <vector>

#include "ident/mode.hpp"

namespace struna::ident {

/// modes.csv: mode,natural_frequency [Hz],natural_frequency_sigma [Hz],lower_half_power [Hz],upper_half_power
/// [Hz],loss_factor [-], loss_factor_sigma [-],damping_ratio [-],flags,circle_natural_frequency
/// [Hz],circle_loss_factor [-], then per output NAME_constant_re [U], NAME_constant_im [U],
/// NAME_constant_sigma [U], last resolves_from [-], stable_orders [-], orders [-]; U the circle form's unit
/// "* /s^2" (viscous "/s").
void write_modes(const ModeSet& modes, const std::string& file);
/// Flags joined by ';', as the file has them.
std::string flag_words(const std::vector<ModeFlag>& flags);
/// Reads what write_modes wrote; also a table with frequency and loss factor or damping ratio only
/// (hand-made). Errors carry file and line: units other than Hz and -, rows out of order, unknown flags.
ModeSet read_modes(const std::string& file);

}  // namespace struna::ident
