#pragma once

#include <Eigen/Core>
#include <complex>

namespace struna::ident {

/// Real transforms of a fixed length N, lines 0 .. N/2: X_k = sum_n x_n exp(-2 pi i k n/N). The same digits
/// in every run. Lengths whose prime factors are small (window.hpp, smooth_length) are fast.
class Fft {
 public:
  explicit Fft(long length);
  ~Fft();
  Fft(const Fft&) = delete;
  Fft& operator=(const Fft&) = delete;

  long length() const { return length_; }
  Eigen::Map<Eigen::VectorXd> input();
  Eigen::Map<const Eigen::VectorXcd> transform();  ///< of the input; valid until the next one

 private:
  long length_;
  double* in_;
  std::complex<double>* out_;
  void* plan_;
};

/// The record of N samples that has the transform given (lines 0 .. N/2).
Eigen::VectorXd inverse_transform(Eigen::VectorXcd transform, long length);

/// sum_n x_n x_{n + j}, indices modulo N, for j = 0 .. N/2, from the record's transform (lines 0 .. N/2),
/// which is that of its even power spectrum; `fft` of length N.
Eigen::VectorXd circular_autocorrelation(const Eigen::Ref<const Eigen::VectorXcd>& transform, Fft& fft);

}  // namespace struna::ident
