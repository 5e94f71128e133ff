#include "ident/line_band.hpp"

namespace struna::ident {

LineBand band_of(const TransferFunction& tf) {
  LineBand band;
  band.lo_hz = tf.frequency_hz(0);
  band.hi_hz = tf.frequency_hz(tf.lines() - 1);
  band.spacing_hz = (band.hi_hz - band.lo_hz) / static_cast<double>(tf.lines() - 1);
  return band;
}

}  // namespace struna::ident
