#pragma once

#include <Eigen/Core>

#include "ident/fft.hpp"

namespace struna::ident {

/// The share of K segments that carry a line's input power, (sum p)^2/(K sum p^2) with p = |X|^2, as a mean
/// over lines weighted by amplitude. Steady excitation has 1, normal noise about 1/2, a sweep that passes a
/// line in one or two segments 1/K to 2/K. `power`: sum p at each line, `square`: sum p^2.
double participation(const Eigen::VectorXd& power, const Eigen::VectorXd& square, long segments);

/// Below it, the excitation passes over the lines one after the other: a sweep, a chirp, a hit, a burst.
inline constexpr double passing_excitation = 0.25;

/// Whether an excitation does, from 15 Hann segments side by side; false for records too short for that.
bool passes_over_lines(const Eigen::VectorXd& input);

/// The period of an excitation without mean in samples, 0 where there is none: the first lag beyond the
/// autocorrelation's first zero at which the record repeats itself, but for 2 % of its power, up to its end.
/// At least two periods are needed. `transform`: lines 0 .. n/2 of the input's first n samples, n the length
/// of `fft`.
long find_period(const Eigen::VectorXd& input, const Eigen::Ref<const Eigen::VectorXcd>& transform, Fft& fft);

}  // namespace struna::ident
