#pragma once

#include <map>
#include <string>
#include <vector>

#include "ident/repeats.hpp"
#include "ident/transfer_function.hpp"

namespace struna::ident {

/// How records become transfer functions.
enum class EstimateMethod {
  automatic,         ///< chosen from the record, see estimate_transfer
  welch,             ///< averaged segments (spectra.hpp)
  local_rational,    ///< local_model.hpp
  local_polynomial,  ///< local_model.hpp
  periodic           ///< mean over whole periods (periodic.hpp)
};
std::string to_string(EstimateMethod method);

/// The words of --estimator: auto, local, local-polynomial, periodic; welch and its ratios h1 (the same as
/// welch), h2, hv, amplitude-ratio. Throws Error on another word.
struct EstimatorWord {
  EstimateMethod method = EstimateMethod::automatic;
  Estimator ratio = Estimator::h1;
};
EstimatorWord estimator_word(const std::string& word);

struct EstimateOptions {
  EstimateMethod method = EstimateMethod::automatic;
  Estimator ratio = Estimator::h1;  ///< of Welch's spectra
  WelchOptions welch;        ///< resolution_hz is every method's line spacing, but for the periodic one
  std::string drive_signal;  ///< channel of what the shaker was asked for, in any unit; empty: none
                             ///< (drive_signal.hpp)
};

struct TransferEstimate {
  TransferFunction function;
  EstimateMethod method = EstimateMethod::welch;  ///< the one taken, never automatic
  Estimator ratio = Estimator::h1;                ///< Welch's
  std::string reason;                             ///< why this one
  Channel input;
  std::string drive_signal;      ///< channel that took the noise on the input out; empty: none
  double sample_interval = 0.0;  ///< [s]
  double resolution_hz = 0.0;    ///< line spacing
  double independent_line_hz =
      0.0;                          ///< what one line of the data is worth: 1/(length of a segment or record)
  double segments = 0.0;            ///< Welch: segments; periodic: periods; local: records
  double effective_averages = 0.0;  ///< Welch's and the periodic one's
  Window window = Window::rectangular;  ///< Welch's
  std::vector<std::string> warnings;
};

/// TransferFunction::leakage_hz of a local polynomial model over its lines' spacing: its bias at 6, 10, 20
/// lines of the record in the half-power band is that of a Hann segment whose lines are as wide
/// (docs/local_model.md); at more it falls faster.
inline constexpr double local_polynomial_leakage = 0.64;

/// Transfer functions from the records of one setup. The automatic choice, in this order:
///  1. Welch, where the options speak of segments: an impact test, a window, a ratio other than h1;
///  2. Welch, where the records hold more than `most_values` numbers: it streams;
///  3. periodic, where all records repeat the first one's period (find_period);
///  4. Welch with one segment per record, where the excitation passes over the lines (passes_over_lines);
///  5. Welch, where the resolution asked for leaves too few lines of the records in a local model's window;
///  6. the local rational model.
/// Its lines are 7.5 of the record's apart, or half of that where a resonance has fewer than six such lines
/// in its half-power band, unless a resolution is asked for. Methods other than Welch hold the spectra of all
/// records in memory, which are as large as the records, and one record beside them (the periodic one: all).
/// With a drive signal the choice goes by it; local models divide the functions over it, means over its
/// periods are free of noise on the motion as they are. Throws Error for options that the method cannot
/// follow, and where the method asked for, or any that takes the drive signal, does not suit the record.
TransferEstimate estimate_transfer(const std::vector<std::string>& files, const std::string& input,
                                   const std::vector<std::string>& outputs, const EstimateOptions& options,
                                   const std::map<std::string, ChannelCorrection>& corrections = {});
TransferEstimate estimate_transfer(const Record& record, const std::string& input,
                                   const std::vector<std::string>& outputs, const EstimateOptions& options);

TransferEstimate estimate_transfer(const std::vector<Record>& records, const std::string& input,
                                   const std::vector<std::string>& outputs, const EstimateOptions& options);

inline constexpr long most_values = 1L << 26;  ///< 512 MiB

}  // namespace struna::ident
