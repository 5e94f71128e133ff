#pragma once

#include <Eigen/Core>
#include <vector>

namespace struna::fem {

/// Poles of many modes side by side, real and imaginary parts apart, so that loops over them become vector
/// instructions. The first `single` modes have one complex pole each, with the mode's own index; the poles of
/// the others follow, grouped by mode; those of rigid modes, q'' - mu q' = p, come last: their z is (q, q').
struct PoleArrays {
  Eigen::ArrayXd re, im;                  ///< mu [1/s]
  Eigen::ArrayXd residue_re, residue_im;  ///< r [s]
  Eigen::ArrayXd inverse_re, inverse_im;  ///< 1/mu [s]
  Eigen::ArrayXd ratio_re, ratio_im;      ///< r/mu [s^2]
  std::vector<int> mode;
  std::vector<int> real_pair;  ///< first pole of each mode with two real poles
  int single = 0;
  int elastic = 0;  ///< poles before the rigid modes'
  int modes = 0;

  int size() const { return static_cast<int>(re.size()); }
};

/// z of every pole.
struct PoleState {
  Eigen::ArrayXd re, im;
};

/// What one step length needs. Under the load p(t) = mean + slope (t/h - 1/2),
///   z(h) = e z(0) + a mean + b slope,   e = exp(mu h), a = r (e - 1)/mu, b = r [((e - 1)/mu - h)/(mu h) - (e
///   - 1)/(2 mu)].
/// Of a rigid mode e = (integral of exp(mu t) over the step, exp(mu h)) and (a, b) are the responses of q and
/// q'.
struct StepCoefficients {
  double step = 0.0;
  Eigen::ArrayXd e_re, e_im, a_re, a_im, b_re, b_im;
  Eigen::ArrayXd flexibility;  ///< per mode: q(h) from rest under a constant unit load [s^2]

  bool with_energy = false;
  // For the energy: integrals of exp(mu t), |exp(mu t)|^2 and exp(mu t)^2 over the step (single poles only).
  Eigen::ArrayXd int_re, int_im, int_abs2, int_square_re, int_square_im;
  /// The same of the two real exponentials of an overdamped mode, alone and in products.
  struct RealPair {
    double one, two, one_one, one_two, two_two;
  };
  std::vector<RealPair> real_pair;
};

void set_step(const PoleArrays& poles, double step, StepCoefficients& coefficients);
/// Adds what step_energy() needs, once per step length.
void set_energy(const PoleArrays& poles, StepCoefficients& coefficients);

/// z(h) without contact; `mean` and `slope` per mode.
void propagate(const PoleArrays& poles, const StepCoefficients& coefficients, const Eigen::ArrayXd& mean,
               const Eigen::ArrayXd& slope, const PoleState& from, PoleState& to);
/// Adds the response to a further constant load per mode.
void add_constant_load(const PoleArrays& poles, const StepCoefficients& coefficients,
                       const Eigen::ArrayXd& load, PoleState& to);

/// q and q' of every mode.
void modal_displacement(const PoleArrays& poles, const PoleState& state, Eigen::VectorXd& q);
void modal_velocity(const PoleArrays& poles, const PoleState& state, Eigen::VectorXd& v);
/// Internal modal force p - q'' = -Re sum mu^2 z.
void modal_internal_force(const PoleArrays& poles, const PoleState& state, Eigen::VectorXd& force);

/// Work of the loads and heat of the dampers over one step [J].
struct StepEnergy {
  double load_work = 0.0;   ///< of the load `mean`, `slope` (without the contact's constant part)
  double dissipated = 0.0;  ///< rigid modes and those with one complex or two real poles: 2 zeta omega times
                            ///< the integral of q'^2
  double internal_work =
      0.0;  ///< other (viscoelastic) modes: work of all loads less the gain of kinetic energy
};
/// `contact` is the constant load per mode that contact adds to `mean`.
StepEnergy step_energy(const PoleArrays& poles, const StepCoefficients& coefficients,
                       const Eigen::ArrayXd& mean, const Eigen::ArrayXd& slope, const Eigen::ArrayXd& contact,
                       const PoleState& from, const PoleState& to);

}  // namespace struna::fem
