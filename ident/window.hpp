#pragma once

#include <Eigen/Core>
#include <string>

namespace struna::ident {

/// automatic: looks at the record, see WelchOptions.
enum class Window { automatic, hann, rectangular, exponential };
Window window_kind(
    const std::string& word);  ///< "auto", "hann", "rectangular", "exponential"; throws Error on another
std::string to_string(Window window);

/// Periodic Hann window, w_n = (1 - cos(2 pi n/N))/2.
Eigen::VectorXd hann_window(long samples);

/// One until the sample `hit`, then exp(-a (n - hit) dt); `decay` a [1/s].
Eigen::VectorXd exponential_window(long samples, long hit, double decay, double sample_interval);

/// Number of independent averages that K segments `hop` samples apart are worth for a stationary record:
///   K / (1 + 2 sum_{j=1}^{K-1} (1 - j/K) rho(j)),  rho(j) = (sum_n w_n w_{n+j hop} / sum_n w_n^2)^2
/// P. D. Welch, IEEE Trans. Audio Electroacoust. AU-15 (1967) 70, the variance of the averaged periodogram.
double effective_averages(const Eigen::VectorXd& window, long segments, long hop);

/// The largest length of at most `samples` with no prime factor above 7, which FFTW does fast.
long smooth_length(long samples);

}  // namespace struna::ident
