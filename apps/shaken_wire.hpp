#pragma once

#include <vector>

#include "fem/closed_forms.hpp"
#include "ident/record.hpp"

namespace struna::apps {

/// White noise on the channels of a record, of each channel's rms.
struct SensorNoise {
  double displacement = 0.0;
  double force = 0.0;
};

/// A straight wire between two clamps, 0.68 m, solid 3.2 mm, 120 GPa, structural damping; one clamp is shaken
/// sideways and the far one's force is read. Everything about it is known in closed form.
struct ShakenWire {
  fem::ClampedBeam beam;
  double loss_factor = 0.02;

  ShakenWire();

  std::vector<double> natural_frequencies_hz(double up_to_hz) const;

  /// What its sensors record: `displacement`, `force_y` at 2 kHz. Motion of flat acceleration (1 m/s^2 rms)
  /// and random phase over the band, steady since long ago; the record is cut out of a period that is longer
  /// by a third, so that it leaks as a measured one does. The band must lie below 800 Hz.
  ident::Record record(double duration, double lo_hz, double hi_hz, const SensorNoise& noise,
                       unsigned seed) const;
};

}  // namespace struna::apps
