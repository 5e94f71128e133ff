#pragma once

#include <functional>
#include <vector>

#include "fem/newmark.hpp"

namespace struna::fem {

/// How far off a step leaves the contacts.
struct StepCheck {
  double estimated_error = 0.0;  ///< of a contact point's displacement, over the largest one
  double checked_until = 0.0;    ///< [s]; 0: nothing touched, nothing was checked
  bool interrupted = false;      ///< `progress` stopped the trials
};

/// Runs with the step and with a quarter of it, up to 20 ms (less where `duration` [s] ends) beyond the first
/// touch, where trajectories have not parted yet; 16/15 of their largest distance is the error of the longer
/// one (which is of first order where touch falls between steps, but of second in the mean: docs/limits.md).
/// Both run from t = 0, the second only where the first has touched: together they cost up to five times a
/// run with the step up to the first touch and 20 ms beyond. `settle`: from the static rest, contacts
/// included; else from the static shape moving with the base. `progress` is called now and then with the time
/// that a trial has reached [s]; false stops. `interval` [s]: between the states that the run looks at, where
/// its steps end; 0: whole steps, 2e-5 s or more. Throws Error as the steppers do.
StepCheck check_step(const std::vector<NodalBody>& bodies, const std::vector<ContactPoint>& points,
                     const PrescribedMotion& motion, double duration, const NewmarkOptions& options,
                     bool settle, const std::function<bool(double)>& progress = {}, double interval = 0.0);
/// The same of the modal method with options.step > 0.
StepCheck check_step(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                     const PrescribedMotion& motion, double duration, const ModalSteppingOptions& options,
                     bool settle, const std::function<bool(double)>& progress = {}, double interval = 0.0);

}  // namespace struna::fem
