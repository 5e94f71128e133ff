#pragma once

#include <Eigen/Core>
#include <memory>

#include "fem/scene.hpp"

namespace struna::fem {

/// One instant of a history: value and its first two time derivatives.
struct MotionSample {
  double displacement = 0.0;  ///< [m] (or force [N], for a driven point)
  double velocity = 0.0;
  double acceleration = 0.0;
};

/// A history that can be asked at any time in [0, duration], at least C2. A value: cheap to copy, immutable.
class MotionHistory {
 public:
  class Source;
  explicit MotionHistory(std::shared_ptr<const Source> source) : source_(std::move(source)) {}
  MotionSample at(double t) const;
  double duration() const;

 private:
  std::shared_ptr<const Source> source_;
};

/// The history an excitation describes (all kinds but record).
MotionHistory motion_history(const Excitation& excitation, double duration);
/// C2 (or smoother) interpolation of samples at a uniform interval.
MotionHistory motion_from_samples(const Eigen::VectorXd& samples, double sample_interval);

}  // namespace struna::fem
