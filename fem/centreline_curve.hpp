#pragma once

#include "fem/centreline.hpp"

namespace struna::fem {

/// The curve behind a Centreline, by its arc length; `s` lies in [0, length()].
class Centreline::Curve {
 public:
  virtual ~Curve() = default;
  virtual double length() const = 0;
  virtual CurvePoint at(double s) const = 0;
  virtual bool is_straight() const { return false; }
};

}  // namespace struna::fem
