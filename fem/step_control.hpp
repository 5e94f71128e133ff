#pragma once

#include <array>
#include <vector>

#include "fem/contact_events.hpp"
#include "fem/modal_stepping.hpp"

namespace struna::fem {

/// u, u', u'' over a step as mean + slope (t/h - 1/2): the projections on constants and on the first Legendre
/// polynomial, so that what is left out is orthogonal to straight lines and its effect is of fourth order.
/// Those of u'' are exact, from u' and u at the ends; those of u' and u follow from the cubic of Hermite.
struct StepLoad {
  std::array<double, 3> mean{};
  std::array<double, 3> slope{};
};
StepLoad step_load(const MotionSample& start, const MotionSample& end, double step);

/// Chooses step lengths from a ladder top/2^level, so that coefficients are computed once per level. Three
/// measures, each against the tolerance: how well a straight line follows the load, how far a cubic may
/// misjudge a gap that is about to close, and the contact forces' estimated share in the displacement.
class StepControl {
 public:
  /// Throws Error unless 0 < tolerance < 1, steps are finite and >= 0, contact_substeps >= 1.
  explicit StepControl(const ModalSteppingOptions& options);

  void set_lowest_pole(double angular_frequency);  ///< [1/s]
  /// Displacement that the tolerance is a fraction of [m].
  void set_scale(double largest_displacement, const std::vector<ContactPoint>& points);

  int level(bool contact) const;
  double step_at(int level) const;
  double event_slack() const;      ///< events are located to this [s]
  double shortest_flight() const;  ///< impacts closer than this make one lasting contact [s]

  void begin_step();
  void see_load(const StepLoad& load, const MotionSample& start, const MotionSample& end,
                const bool (&drives)[3]);
  void see_path(const PenetrationPath& path);
  /// A point that is closed without force: how far k g + c g' may swell between the ends of the step.
  void see_idle(const PenetrationPath& path, const ContactForceLaw& law);
  /// Whether the step just tried is too long; adapts the level either way.
  bool reject(bool contact, double contact_error);
  /// After contact forces that were not found: the next shorter step. False where there is none.
  bool shorten(bool contact);
  void restart_contact();

 private:
  bool fixed() const { return options_.step > 0.0; }

  ModalSteppingOptions options_;
  double top_ = 1e-3;
  double scale_ = 0.0;
  int free_level_ = 10;
  int contact_level_ = 10;
  int touch_level_ = 10;
  bool first_after_touch_ = false;
  std::array<double, 3> largest_load_{};
  double load_measure_ = 0.0;
  double path_measure_ = 0.0;
};

}  // namespace struna::fem
