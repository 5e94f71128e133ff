#pragma once

#include "fem/contact_solver.hpp"
#include "fem/modal_stepping.hpp"

namespace struna::fem {

/// Penetration and its rate of one point at both ends of a step; between them the cubic of Hermite speaks.
struct PenetrationPath {
  double step = 0.0;
  double start = 0.0, start_rate = 0.0;
  double end = 0.0, end_rate = 0.0;

  double at(double t) const;
  double rate_at(double t) const;
  double curvature_at(double t) const;
};

/// An event on a path: its time from the start of the step (infinite: none) and what it is.
struct PathEvent {
  double time;
  ContactEvent::Kind kind = ContactEvent::Kind::touch;
};

/// The first event that is due by `horizon`, the end of the step or a little beyond it (the cubic continued).
/// A point that is open may also touch and leave again within the step.
PathEvent first_event(const PenetrationPath& path, ContactPhase phase, const ContactForceLaw& law,
                      double horizon);

/// The phase that an event leads to, for penetration rate `rate`.
ContactPhase phase_after(ContactEvent::Kind kind, const ContactForceLaw& law, double rate);

/// The phase of a closed contact found in that state (a start).
ContactPhase phase_of(const ContactForceLaw& law, double penetration, double rate);

/// The law's force at an instant, by phase [N] (the error estimate's view of it).
double phase_force(const ContactForceLaw& law, ContactPhase phase, double penetration, double rate);

}  // namespace struna::fem
