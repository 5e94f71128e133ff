#include "fem/modal_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "fem/error.hpp"

namespace struna::fem {
namespace {

/// Modes and contact components below this share of the largest are rounding, not coupling.
constexpr double rounding = 1e-9;

/// The vectors seen so far at one contact point span nothing, a line or the plane.
struct Span {
  int dimension = 0;
  Eigen::Vector2d line = Eigen::Vector2d::UnitX();

  /// True when `v` enlarges the span; `scale`: the size against which v's parts are rounding.
  bool add(const Eigen::Vector2d& v, double scale) {
    if (dimension == 2 || v.norm() <= rounding * scale) return false;
    if (dimension == 0) {
      line = v.normalized();
      dimension = 1;
      return true;
    }
    const double across = v[0] * line[1] - v[1] * line[0];
    if (std::abs(across) <= rounding * scale) return false;
    dimension = 2;
    return true;
  }
};

/// The size of a mode's coupling to the force that can act in the span.
double coupling(const Span& span, const Eigen::Vector2d& row) {
  return span.dimension == 0 ? 0.0 : span.dimension == 1 ? std::abs(row.dot(span.line)) : row.norm();
}

/// What moves: starting from loads and initial states, contact forces along the directions in which points
/// move excite further modes, until nothing is added.
struct Spread {
  std::vector<std::vector<char>> active;
  std::vector<Span> span;
};

const Eigen::MatrixX2d* rows_of(const ContactPoint& point, int body) {
  if (body == point.inside_body) return &point.inside;
  if (body == point.outside_body) return &point.outside;
  return nullptr;
}

Spread spread_excitation(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                         const std::vector<std::vector<char>>& moving) {
  Spread found{moving, std::vector<Span>(points.size())};
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const ModalBody& body = bodies[b];
    const double constant = body.constant_load.size() ? body.constant_load.cwiseAbs().maxCoeff() : 0.0;
    for (int m = 0; m < body.poles.modes; ++m) {
      bool loaded = constant > 0.0 && std::abs(body.constant_load[m]) > rounding * constant;
      for (int d = 0; d < 3; ++d) {
        loaded = loaded || std::abs(body.load(m, d)) > rounding * body.load.col(d).cwiseAbs().maxCoeff();
      }
      if (loaded) found.active[b][m] = 1;
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].shape == StopShape::wall) found.span[i] = {1, Eigen::Vector2d::UnitX()};
    found.span[i].add(points[i].rest_offset, points[i].gap);
    found.span[i].add(points[i].motion, points[i].motion.norm());
    // Only the component across a wall acts.
    if (points[i].shape == StopShape::wall) found.span[i] = {1, Eigen::Vector2d::UnitX()};
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const ContactPoint& point = points[i];
      for (std::size_t b = 0; b < bodies.size(); ++b) {
        const Eigen::MatrixX2d* rows = rows_of(point, static_cast<int>(b));
        if (rows == nullptr || rows->rows() == 0) continue;
        const double scale = rows->rowwise().norm().maxCoeff();
        for (int m = 0; m < rows->rows(); ++m) {
          const Eigen::Vector2d row = rows->row(m);
          if (found.active[b][m]) {
            if (point.shape == StopShape::bore) changed = found.span[i].add(row, scale) || changed;
          } else if (coupling(found.span[i], row) > rounding * scale) {
            found.active[b][m] = 1;
            changed = true;
          }
        }
      }
    }
  }
  return found;
}

/// First pole of each mode of a body, and the end.
std::vector<int> pole_starts(const PoleSystem& poles) {
  std::vector<int> start(poles.modes + 1, static_cast<int>(poles.pole.size()));
  for (int k = static_cast<int>(poles.pole.size()) - 1; k >= 0; --k) start[poles.mode[k]] = k;
  return start;
}

/// q/p of an elastic mode under a constant load [s^2].
double static_compliance(const PoleSystem& poles, int begin, int end) {
  std::complex<double> sum = 0.0;
  for (int k = begin; k < end; ++k) sum -= poles.residue[k] / poles.pole[k];
  return sum.real();
}

/// 0 for a rigid mode.
double mode_frequency_hz(const PoleSystem& poles, int begin, int end) {
  if (is_rigid_pole(poles, begin, end)) return 0.0;
  double largest = 0.0;
  for (int k = begin; k < end; ++k) {
    // The oscillating pole tells; real pairs by their geometric mean.
    if (poles.pole[k].imag() != 0.0) return std::abs(poles.pole[k]) / (2.0 * std::numbers::pi);
    largest = std::max(largest, std::abs(poles.pole[k]));
  }
  if (end - begin == 2) largest = std::sqrt(std::abs(poles.pole[begin] * poles.pole[begin + 1]));
  return largest / (2.0 * std::numbers::pi);
}

/// The row of one point, one component `axis`, for a mode of a body (0 when the body has no part in it).
Eigen::Vector2d contact_row(const ContactPoint& point, const ModalOrigin& mode) {
  Eigen::Vector2d row = Eigen::Vector2d::Zero();
  if (mode.body == point.inside_body) row += point.inside.row(mode.index).transpose();
  if (mode.body == point.outside_body) row -= point.outside.row(mode.index).transpose();
  return row;
}

RowMatrix contact_rows(const ModalSystem& system, const std::vector<ContactPoint>& points,
                       const std::vector<ModalOrigin>& modes) {
  RowMatrix rows(static_cast<int>(points.size()) * system.dimension, static_cast<int>(modes.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t m = 0; m < modes.size(); ++m) {
      const Eigen::Vector2d row = contact_row(points[i], modes[m]);
      const int at = static_cast<int>(i) * system.dimension;
      if (system.dimension == 1) {
        rows(at, static_cast<int>(m)) = row.dot(system.line[i]);
      } else {
        rows.col(static_cast<int>(m)).segment<2>(at) = row;
      }
    }
  }
  return rows;
}

enum class PoleGroup { single, several, rigid };  ///< in PoleArrays' order

PoleGroup pole_group(const PoleSystem& poles, int begin, int end) {
  if (is_rigid_pole(poles, begin, end)) return PoleGroup::rigid;
  return end - begin == 1 ? PoleGroup::single : PoleGroup::several;
}

/// More than one complex pole or two real ones.
bool is_viscoelastic(const PoleSystem& poles, int begin, int end) {
  if (end - begin == 2) return poles.pole[begin].imag() != 0.0 || poles.pole[begin + 1].imag() != 0.0;
  return pole_group(poles, begin, end) == PoleGroup::several;
}

void append_mode(ModalSystem& system, const std::vector<ModalBody>& bodies, const ModalOrigin& origin,
                 int begin, int end, std::vector<std::complex<double>>& pole,
                 std::vector<std::complex<double>>& residue) {
  const PoleSystem& poles = bodies[origin.body].poles;
  const int mode = static_cast<int>(system.mode_origin.size());
  system.mode_origin.push_back(origin);
  if (!is_viscoelastic(poles, begin, end) && end - begin == 2) {
    system.poles.real_pair.push_back(static_cast<int>(pole.size()));
  }
  for (int k = begin; k < end; ++k) {
    pole.push_back(poles.pole[k]);
    residue.push_back(poles.residue[k]);
    system.poles.mode.push_back(mode);
    system.pole_origin.push_back({origin.body, k});
  }
}

void fill_modes(ModalSystem& system, const std::vector<ModalBody>& bodies) {
  const int modes = static_cast<int>(system.mode_origin.size());
  system.poles.modes = modes;
  system.load.resize(modes, 3);
  system.constant_load.setZero(modes);
  system.relaxed_stiffness.resize(modes);
  system.rest_stiffness.resize(modes);
  for (int m = 0; m < modes; ++m) {
    const ModalOrigin origin = system.mode_origin[m];
    const ModalBody& body = bodies[origin.body];
    system.load.row(m) = body.load.row(origin.index).array();
    if (body.constant_load.size()) system.constant_load[m] = body.constant_load[origin.index];
    const std::vector<int> start = pole_starts(body.poles);
    const int begin = start[origin.index], end = start[origin.index + 1];
    system.relaxed_stiffness[m] =
        is_rigid_pole(body.poles, begin, end) ? 0.0 : 1.0 / static_compliance(body.poles, begin, end);
    system.rest_stiffness[m] = body.poles.rest_stiffness.size() ? body.poles.rest_stiffness[origin.index]
                                                                : system.relaxed_stiffness[m];
    system.viscoelastic.push_back(is_viscoelastic(body.poles, begin, end));
    system.frequency_hz.push_back(mode_frequency_hz(body.poles, begin, end));
  }
}

void fill_poles(PoleArrays& poles, const std::vector<std::complex<double>>& pole,
                const std::vector<std::complex<double>>& residue) {
  const int n = static_cast<int>(pole.size());
  for (Eigen::ArrayXd* array : {&poles.re, &poles.im, &poles.residue_re, &poles.residue_im, &poles.inverse_re,
                                &poles.inverse_im, &poles.ratio_re, &poles.ratio_im}) {
    array->setZero(n);
  }
  for (int k = 0; k < n; ++k) {
    poles.re[k] = pole[k].real();
    poles.im[k] = pole[k].imag();
    poles.residue_re[k] = residue[k].real();
    poles.residue_im[k] = residue[k].imag();
    if (k >= poles.elastic) {  // the state is (q, q'): an impulse adds to q'
      poles.residue_re[k] = 0.0;
      poles.residue_im[k] = 1.0;
      continue;
    }
    poles.inverse_re[k] = (1.0 / pole[k]).real();
    poles.inverse_im[k] = (1.0 / pole[k]).imag();
    poles.ratio_re[k] = (residue[k] / pole[k]).real();
    poles.ratio_im[k] = (residue[k] / pole[k]).imag();
  }
}

void fill_static_loads(ModalSystem& system, const std::vector<ModalBody>& bodies) {
  const int modes = static_cast<int>(system.static_origin.size());
  system.static_load.resize(modes, 3);
  system.static_constant_load.setZero(modes);
  for (int m = 0; m < modes; ++m) {
    const ModalOrigin origin = system.static_origin[m];
    const ModalBody& body = bodies[origin.body];
    system.static_load.row(m) = body.load.row(origin.index).array();
    if (body.constant_load.size()) system.static_constant_load[m] = body.constant_load[origin.index];
  }
}

void fill_points(ModalSystem& system, const std::vector<ContactPoint>& points) {
  const int d = system.dimension;
  const int n = static_cast<int>(points.size());
  system.rest.resize(n * d);
  system.motion.resize(n * d);
  for (int i = 0; i < n; ++i) {
    if (d == 1) {
      system.rest[i] = points[i].rest_offset.dot(system.line[i]);
      system.motion[i] = points[i].motion.dot(system.line[i]);
    } else {
      system.rest.segment<2>(2 * i) = points[i].rest_offset;
      system.motion.segment<2>(2 * i) = points[i].motion;
    }
  }
  system.rows = contact_rows(system, points, system.mode_origin);
  if (system.static_origin.empty()) return;
  system.static_rows = contact_rows(system, points, system.static_origin);
  const auto deflection = [&](const Eigen::ArrayXd& load) -> Eigen::VectorXd {
    return system.static_rows * (system.static_compliance * load).matrix();
  };
  system.rest += deflection(system.static_constant_load);
  system.motion += deflection(system.static_load.col(0));
  system.static_flexibility =
      system.static_rows * system.static_compliance.matrix().asDiagonal() * system.static_rows.transpose();
}

}  // namespace

ModalSystem modal_system(const std::vector<ModalBody>& bodies, const std::vector<ContactPoint>& points,
                         const std::vector<std::vector<char>>& moving, double highest_mode_hz) {
  const Spread excitation = spread_excitation(bodies, points, moving);
  ModalSystem system;
  const bool planar = std::all_of(excitation.span.begin(), excitation.span.end(),
                                  [](const Span& span) { return span.dimension < 2; });
  system.dimension = planar ? 1 : 2;
  for (const Span& span : excitation.span) system.line.push_back(span.line);

  std::vector<std::complex<double>> pole, residue;
  std::vector<double> compliance;
  for (const PoleGroup group : {PoleGroup::single, PoleGroup::several, PoleGroup::rigid}) {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const PoleSystem& poles = bodies[b].poles;
      const std::vector<int> start = pole_starts(poles);
      for (int m = 0; m < poles.modes; ++m) {
        if (pole_group(poles, start[m], start[m + 1]) != group) continue;
        const ModalOrigin origin{static_cast<int>(b), m};
        if (!excitation.active[b][m]) {
          ++system.idle_modes;
        } else if (highest_mode_hz > 0.0 && group != PoleGroup::rigid &&
                   mode_frequency_hz(poles, start[m], start[m + 1]) > highest_mode_hz && !moving[b][m]) {
          system.static_origin.push_back(origin);
          // What it follows lies not far below its own frequency: the modulus there, not the relaxed one.
          const double omega = 2.0 * std::numbers::pi * mode_frequency_hz(poles, start[m], start[m + 1]);
          compliance.push_back(1.0 / (omega * omega));
        } else {
          append_mode(system, bodies, origin, start[m], start[m + 1], pole, residue);
        }
      }
    }
    if (group == PoleGroup::single) system.poles.single = static_cast<int>(system.mode_origin.size());
    if (group != PoleGroup::rigid) system.poles.elastic = static_cast<int>(pole.size());
  }
  system.static_compliance =
      Eigen::Map<Eigen::ArrayXd>(compliance.data(), static_cast<Eigen::Index>(compliance.size()));
  fill_poles(system.poles, pole, residue);
  fill_modes(system, bodies);
  fill_static_loads(system, bodies);
  fill_points(system, points);
  return system;
}

void validate(const std::vector<ModalBody>& bodies) {
  if (bodies.empty()) throw Error("ModalStepper: at least 1 body, got 0");
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const ModalBody& body = bodies[b];
    const auto fail = [&](const std::string& what) {
      throw Error(fmt::format("ModalStepper: body {}: {}", b, what));
    };
    const Eigen::Index n = body.poles.pole.size();
    if (body.poles.mode.size() != n || body.poles.residue.size() != n) {
      fail(fmt::format("poles, modes and residues must be equally many, got {}, {} and {}", n,
                       body.poles.mode.size(), body.poles.residue.size()));
    }
    if (body.load.rows() != body.poles.modes) {
      fail(fmt::format("load must have one row per mode ({}), got {}", body.poles.modes, body.load.rows()));
    }
    if (body.constant_load.size() != 0 && body.constant_load.size() != body.poles.modes) {
      fail(fmt::format("constant_load must have {} entries or none, got {}", body.poles.modes,
                       body.constant_load.size()));
    }
    if (body.poles.rest_stiffness.size() != 0 && body.poles.rest_stiffness.size() != body.poles.modes) {
      fail(fmt::format("rest_stiffness must have {} entries or none, got {}", body.poles.modes,
                       body.poles.rest_stiffness.size()));
    }
    if (!body.load.allFinite() || !body.constant_load.allFinite()) fail("loads must be finite");
    for (Eigen::Index k = 0; k < n; ++k) {
      const std::complex<double> mu = body.poles.pole[k];
      const bool alone = (k == 0 || body.poles.mode[k - 1] != body.poles.mode[k]) &&
                         (k + 1 == n || body.poles.mode[k + 1] != body.poles.mode[k]);
      if (!std::isfinite(mu.real()) || !std::isfinite(mu.imag()) || mu.real() > 0.0 ||
          (mu == 0.0 && !alone)) {
        fail(fmt::format(
            "pole {} must be finite, with a real part <= 0, zero only as a rigid mode's one, got {} + {}i", k,
            mu.real(), mu.imag()));
      }
      if (alone && mu.imag() == 0.0 && body.poles.residue[k] != 1.0) {
        fail(fmt::format("pole {} is a rigid mode's, so its residue must be 1, got {} + {}i", k,
                         body.poles.residue[k].real(), body.poles.residue[k].imag()));
      }
      const int mode = body.poles.mode[k];
      if (mode < 0 || mode >= body.poles.modes || (k > 0 && mode < body.poles.mode[k - 1])) {
        fail(fmt::format("poles must be ordered by mode, got mode {} at pole {}", mode, k));
      }
    }
  }
}

}  // namespace struna::fem
