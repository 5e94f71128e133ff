#include "ident/fft.hpp"

#include <fftw3.h>

#include <mutex>

namespace struna::ident {
namespace {

std::mutex& planner() {  // FFTW's planner is not thread-safe
  static std::mutex mutex;
  return mutex;
}

fftw_complex* fftw(std::complex<double>* values) {
  return reinterpret_cast<fftw_complex*>(values);
}

}  // namespace

Fft::Fft(long length)
    : length_(length),
      in_(fftw_alloc_real(static_cast<std::size_t>(length))),
      out_(reinterpret_cast<std::complex<double>*>(
          fftw_alloc_complex(static_cast<std::size_t>(length / 2 + 1)))) {
  const std::lock_guard lock(planner());
  plan_ = fftw_plan_dft_r2c_1d(static_cast<int>(length), in_, fftw(out_), FFTW_ESTIMATE);
}

Fft::~Fft() {
  const std::lock_guard lock(planner());
  fftw_destroy_plan(static_cast<fftw_plan>(plan_));
  fftw_free(in_);
  fftw_free(out_);
}

Eigen::Map<Eigen::VectorXd> Fft::input() {
  return {in_, length_};
}

Eigen::Map<const Eigen::VectorXcd> Fft::transform() {
  fftw_execute(static_cast<fftw_plan>(plan_));
  return {out_, length_ / 2 + 1};
}

Eigen::VectorXd inverse_transform(Eigen::VectorXcd transform, long length) {
  Eigen::VectorXd result(length);
  fftw_plan plan = nullptr;
  {
    const std::lock_guard lock(planner());
    plan =
        fftw_plan_dft_c2r_1d(static_cast<int>(length), fftw(transform.data()), result.data(), FFTW_ESTIMATE);
  }
  fftw_execute(plan);
  const std::lock_guard lock(planner());
  fftw_destroy_plan(plan);
  return result / static_cast<double>(length);
}

Eigen::VectorXd circular_autocorrelation(const Eigen::Ref<const Eigen::VectorXcd>& transform, Fft& fft) {
  const long length = fft.length(), lines = length / 2 + 1;
  auto power = fft.input();
  power.head(lines) = transform.cwiseAbs2();
  power.tail(length - lines) = power.segment(1, length - lines).reverse();
  return fft.transform().real() / static_cast<double>(length);
}

}  // namespace struna::ident
