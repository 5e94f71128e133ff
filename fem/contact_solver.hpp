#pragma once

#include <vector>

#include "fem/contact_geometry.hpp"
#include "fem/modal_system.hpp"

namespace struna::fem {

/// What a contact point does between two events. approach: loading while it approaches, unloading after; the
/// other laws: pushing, and idle where the gap is closed but the law would pull.
enum class ContactPhase : char { open, loading, unloading, pushing, idle };

/// Whether a force acts in the phase.
inline bool transmits(ContactPhase phase) {
  return phase != ContactPhase::open && phase != ContactPhase::idle;
}

/// Distance of the point from the bore's axis, or along the wall's normal; g = distance - gap.
double contact_distance(StopShape shape, const double* offset, int dimension);

/// A closed contact during one step; offsets have `dimension` components.
struct ClosedContact {
  int point = 0;
  const ContactForceLaw* law = nullptr;
  ContactPhase phase = ContactPhase::loading;
  StopShape shape = StopShape::bore;
  double gap = 0.0;
  double prior_penetration = 0.0;  ///< before the step: what the dashpot counts from
  double start_offset[2] = {};     ///< in: without deflection of static modes; out: with the step's
  double start_penetration = 0.0;  ///< out
  double end_offset[2] = {};       ///< in: without contact; out: with it
  double end_penetration = 0.0;
  double force = 0.0;               ///< in: a guess; out: the constant force of the step [N]
  double direction[2] = {};         ///< -(force on the inside body)/|force|
  double normal_flexibility = 0.0;  ///< direction . W direction [m/N]
};

/// The constant forces of one step, condensed to the closed contacts:
///   h1 = h_free - W n F,   F = law over the step's mean,   n = (h0 + h1)/(|h0| + |h1|)
/// by Newton with the directions following. Modes left to statics (flexibility W_s, part of W) follow the
/// force of the step from its start, h0 = h0_free - W_s n F: a spring k in series with them then answers as
/// k/(1 + k W_s) and cannot swing from step to step; the dashpot sees their jump. The discrete gradient: F n
/// . (h1 - h0) is the change of the contact's energy plus its heat, to rounding (Gonzalez, J. Nonlinear Sci.
/// 6 (1996) 449).
class ContactSolver {
 public:
  /// Reserves for `points` contacts.
  void reserve(int points, int dimension);
  /// `w`: flexibility of the closed contacts' components, (contacts x dimension) square; `w_static`: its part
  /// from static modes, empty without them. False: not converged.
  bool solve(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w,
             const RowMatrix& w_static, double step);

 private:
  void move(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w);
  void move_start(std::vector<ClosedContact>& contacts, int dimension, const RowMatrix& w_static);
  /// Solves J x = b in place, J from residual slopes; n x n.
  void eliminate(int n);

  std::vector<double> free_, start_free_, jacobian_, update_, slope_, start_slope_;
};

/// Heat of one closed contact over a step [J]: the dashpot's force times g1 - g0.
double contact_heat(const ClosedContact& contact, double step);

}  // namespace struna::fem
