#pragma once

#include <Eigen/Core>

namespace struna::fem {

/// Four numbers that go through the same arithmetic, as a scalar of Eigen's matrices: one per element, so
/// that four elements are computed at once. A single element's 6 x 6 matrices fill no vector registers and
/// its operations wait for each other; with lanes each operation is a full vector instruction whatever the
/// shape of the matrices, and four chains of operations share the waiting.
class Lane {
 public:
  static constexpr int count = 4;

  Lane() = default;
  Lane(double all) : value_{all, all, all, all} {}  // implicit: Eigen writes Scalar(0)

  double operator[](int lane) const { return value_[lane]; }
  void set(int lane, double value) { value_[lane] = value; }

  Lane& operator+=(const Lane& b) { return value_ += b.value_, *this; }
  Lane& operator-=(const Lane& b) { return value_ -= b.value_, *this; }
  Lane& operator*=(const Lane& b) { return value_ *= b.value_, *this; }
  Lane& operator/=(const Lane& b) { return value_ /= b.value_, *this; }

  friend Lane operator+(const Lane& a, const Lane& b) { return Lane(a) += b; }
  friend Lane operator-(const Lane& a, const Lane& b) { return Lane(a) -= b; }
  friend Lane operator*(const Lane& a, const Lane& b) { return Lane(a) *= b; }
  friend Lane operator/(const Lane& a, const Lane& b) { return Lane(a) /= b; }
  friend Lane operator-(const Lane& a) { return Lane(0.0) -= a; }

 private:
  // A vector of the compiler's (GCC, Clang), which splits it where the machine's registers are shorter.
  using Numbers = double __attribute__((vector_size(count * sizeof(double))));
  Numbers value_;
};

}  // namespace struna::fem

namespace Eigen {

template <>
struct NumTraits<struna::fem::Lane> : NumTraits<double> {
  using Real = struna::fem::Lane;
  using NonInteger = struna::fem::Lane;
  using Nested = struna::fem::Lane;
  using Literal = double;
};

}  // namespace Eigen
