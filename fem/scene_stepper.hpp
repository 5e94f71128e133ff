#pragma once

#include <memory>
#include <vector>

#include "fem/newmark.hpp"
#include "fem/sampled_run.hpp"

namespace struna::fem {

/// A planned scene in either method's hands, at time zero: from the static shape moving with the base, or
/// `settled`, in equilibrium with gravity and the contacts. Without `contact` no point of the plan takes
/// part. The plan must outlive what is returned.
std::unique_ptr<Stepper> modal_run(const SimulationPlan& plan, std::vector<ModalBody> bodies, bool contact,
                                   const MotionHistory& motion, const ModalSteppingOptions& options,
                                   bool settled);
std::unique_ptr<Stepper> newmark_run(const SimulationPlan& plan, std::vector<NodalBody> bodies, bool contact,
                                     const MotionHistory& motion, const NewmarkOptions& options,
                                     bool settled);

}  // namespace struna::fem
