#pragma once

#include <functional>
#include <vector>

#include "fem/modal_stepping.hpp"

namespace struna::fem {

/// One trial's setting and outcome.
struct AccuracyTrial {
  double tolerance = 0.0;        ///< of the stepper
  double highest_mode_hz = 0.0;  ///< 0: every mode is stepped
  double error =
      0.0;         ///< against the reference, plus the reference's own. Infinite: contacts did not converge
  long steps = 0;  ///< up to the end of the window
  int modes = 0;   ///< stepped
  /// What it costs: steps times modes.
  double cost() const { return static_cast<double>(steps) * modes; }
};

/// What a ModalStepper needs to keep a tolerance, and how that was checked.
struct AccuracyChoice {
  double highest_mode_hz = 0.0;  ///< modes above follow statically; 0: every mode is stepped
  double tolerance = 1e-3;       ///< for the stepper; below the one asked where that was not enough
  double estimated_error = 0.0;  ///< of a contact point's displacement, over the largest one
  double checked_from = 0.0;     ///< [s] the first touch
  double checked_until = 0.0;    ///< [s]
  double known_until = 0.0;      ///< [s] the error estimated keeps the tolerance asked up to here
  bool interrupted = false;      ///< `progress` stopped the trials: nothing is chosen
  AccuracyTrial chosen;
  AccuracyTrial reference;
  std::vector<AccuracyTrial> less;  ///< one level less: of steps, of modes; only when asked for
};

/// The lowest frequency above which modes may be left to statics under a motion that ends at `highest_hz`
/// [Hz]: what they then lack of their answer to it is (f/f_r)^2, below `tolerance`.
double static_mode_limit(double highest_hz, double tolerance);

/// The lowest frequency that modes of a run with contact are tried to be cut at [Hz]: a quarter of
/// static_mode_limit(), which is an upper bound, but no less than `highest_hz`. `steady`: the trials see what
/// the whole run does; a sweep or a record may reach the upper end of its band later, and is cut at
/// static_mode_limit() at the earliest.
double first_cut_hz(double highest_hz, double tolerance, bool steady);

/// Chooses modes and steps by trial, up to 20 ms (less where `duration` [s] ends) beyond the first touch.
/// Every mode at four times the tolerance asked, tightened by four (four times at most) until the error is
/// below half of what is asked; then fewer modes, from `first_cut_hz` upwards by octaves: the first that
/// keeps below half is taken. The reference of a trial has every mode and a 64th of the trial's tolerance, so
/// it is tightened with the trials; its own error is told from how far the two are apart, and added. docs:
/// modal_stepping.md. Where nothing touches within the duration, nothing is tried: the tolerance stands and
/// estimated_error is 0. Where no trial meets the tolerance, the loosest one that errs little more than the
/// best is taken, and the estimated error tells, and known_until. `options.tolerance` is what is asked;
/// `settle`: trials start from the static rest; `progress` is called now and then with the time that a trial
/// has reached [s], false stops; `levels`: tries as well what four times the stepper's tolerance and half the
/// highest mode would give.
AccuracyChoice choose_accuracy(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                               const PrescribedMotion& motion, double first_cut_hz, double duration,
                               const ModalSteppingOptions& options, bool settle,
                               const std::function<bool(double)>& progress = {}, bool levels = false,
                               double interval = 2.5e-5);

}  // namespace struna::fem
