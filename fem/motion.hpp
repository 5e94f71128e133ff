#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "fem/scene.hpp"

namespace struna::fem {

/// One instant of a history: value and its first two time derivatives.
struct MotionSample {
  double displacement = 0.0;  ///< [m] (or force [N], for a driven point)
  double velocity = 0.0;      ///< [m/s]
  double acceleration = 0.0;  ///< [m/s^2]
};

/// A history that can be asked at any time in [0, duration], at least C2: velocity and acceleration are the
/// exact derivatives of the displacement, so base motion enters without drift. A value: cheap to copy,
/// immutable.
class MotionHistory {
 public:
  class Source;  ///< closed form or table (motion.cpp)
  MotionHistory(std::shared_ptr<const Source> source, double duration, double highest_hz,
                std::string note = {})
      : source_(std::move(source)), duration_(duration), highest_hz_(highest_hz), note_(std::move(note)) {}
  /// Throws Error outside [0, duration].
  MotionSample at(double t) const;
  double duration() const { return duration_; }
  /// Upper edge of the band that the motion fills [Hz]; half the sampling rate of a record.
  double highest_hz() const { return highest_hz_; }
  /// What was done to a record's samples; empty: nothing.
  const std::string& note() const { return note_; }

 private:
  std::shared_ptr<const Source> source_;
  double duration_;
  double highest_hz_;
  std::string note_;
};

/// The history an excitation describes, by kind:
///   sine       x = -(a/w^2) sin(w t)
///   chirp      x = -(a/w^2) sin(phase), w = phase' rising linearly from band_lo to band_hi over the duration
///   multisine  lines of equal acceleration and random phase at the multiples of 1/multisine_period() in the
///   band;
///              rms_acceleration is exact over a period
///   random     band-limited Gaussian: lines of Rayleigh amplitude and random phase, closer than 1/duration,
///   so that nothing
///              repeats; scaled so that rms_acceleration is exact over the duration
/// The draws come from std::mt19937_64 through this library's own transforms: one seed is one motion on every
/// machine. Throws Error on a record (its samples are not here: motion_from_samples), and on values out of
/// range.
MotionHistory motion_history(const Excitation& excitation, double duration);

/// Period of a multisine [s]: half the duration, so that the second half of a run is one settled period.
double multisine_period(double duration);

/// Seventh-degree spline (C6) through samples at a uniform interval [s]; duration (samples - 1) interval.
/// Nothing is filtered or detrended; but where the record starts with the edge of a resampling filter, its
/// first samples are reconstructed (find_resampling_edge) and note() tells so. Beyond its ends the record is
/// continued point-symmetrically, which only matters within a few samples of them. Throws Error on fewer than
/// 8 samples or values that are not finite.
MotionHistory motion_from_samples(const Eigen::VectorXd& samples, double sample_interval);

}  // namespace struna::fem
