#include "fem/sampled_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/decimator.hpp"

namespace struna::fem {
namespace {

using Eigen::VectorXd;

/// The measured quantities of a state. Modes that only follow statically add no inertia.
class OutputReader {
 public:
  OutputReader(const SimulationPlan& plan, MaxwellLaw law, const MotionSample& start)
      : plan_(plan), memory_(std::move(law), start) {}

  VectorXd read(const Stepper& stepper, const MotionSample& u, double interval, bool contact) {
    if (interval > 0.0) memory_.advance(interval, u);
    const int body = plan_.measured_body;
    const VectorXd x = stepper.displacement(body);
    const VectorXd v = stepper.velocity(body);
    const VectorXd a = stepper.acceleration(body, u);
    VectorXd y(static_cast<long>(plan_.rows.size()));
    for (std::size_t k = 0; k < plan_.rows.size(); ++k) {
      const OutputRow& row = plan_.rows[k];
      y[static_cast<long>(k)] =
          row.on_displacement.dot(x) + row.on_velocity.dot(v) + row.on_acceleration.dot(a) +
          row.on_motion.dot(Eigen::Vector3d(u.displacement, u.velocity, u.acceleration)) +
          row.static_stiffness * memory_.value() + row.constant;
    }
    for (std::size_t i = 0; contact && i < plan_.points.size(); ++i) {
      const Eigen::Vector2d f = stepper.force_on_inside(static_cast<int>(i));
      if (f.isZero(0.0)) continue;
      for (std::size_t k = 0; k < plan_.rows.size(); ++k) {
        y[static_cast<long>(k)] += plan_.rows[k].on_contact.row(static_cast<long>(i)) * f;
      }
    }
    return y;
  }

 private:
  const SimulationPlan& plan_;
  ModulusMemory memory_;
};

/// Time bins of the contact maps, and of the checks of linear beam theory.
constexpr long largest_bin_count = 2000;

class Observer {
 public:
  Observer(const SimulationPlan& plan, const Sampling& sampling) : plan_(plan) {
    const long fine = sampling.samples * sampling.oversampling;
    per_bin_ = std::max(1L, (fine + largest_bin_count - 1) / largest_bin_count);
    const long bins = (fine + per_bin_ - 1) / per_bin_;
    const auto points = static_cast<long>(plan.points.size());
    penetration_ = Eigen::MatrixXd::Constant(bins, points, -std::numeric_limits<double>::infinity());
    force_ = Eigen::MatrixXd::Zero(bins, points);
    bin_interval_ = static_cast<double>(per_bin_) * sampling.interval();
    bodies_.resize(plan.bodies.size());
  }

  void contact(long fine, const Stepper& stepper) {
    const long bin = fine / per_bin_;
    for (long i = 0; i < penetration_.cols(); ++i) {
      penetration_(bin, i) = std::max(penetration_(bin, i), stepper.penetration(static_cast<int>(i)));
      force_(bin, i) = std::max(force_(bin, i), stepper.force(static_cast<int>(i)));
    }
    bins_seen_ = bin + 1;
  }

  void shapes(long fine, const Stepper& stepper, const MotionSample& u) {
    if (fine % per_bin_ != 0) return;
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      observe_body(b, stepper.displacement(static_cast<int>(b)), u);
  }

  std::vector<SimulatedBody> bodies() const { return bodies_; }
  /// Deepest penetration so far [m].
  double deepest() const { return penetration_.size() > 0 ? penetration_.maxCoeff() : 0.0; }

  std::vector<ContactMap> maps() const {
    std::vector<ContactMap> maps;
    for (std::size_t from = 0; from < plan_.contacts.size();) {
      const Contact* contact = plan_.contacts[from];
      std::size_t to = from;
      while (to < plan_.contacts.size() && plan_.contacts[to] == contact) ++to;
      const auto first = static_cast<long>(from);
      const auto count = static_cast<long>(to - from);
      ContactMap map{contact->inside, contact->outside, contact->gap, VectorXd(count), bin_interval_, {}, {}};
      for (long i = 0; i < count; ++i) {
        map.arc_length[i] = plan_.pairs[from + static_cast<std::size_t>(i)].pair.inside_arc_length;
      }
      map.penetration = penetration_.block(0, first, bins_seen_, count);
      map.force = force_.block(0, first, bins_seen_, count);
      maps.push_back(std::move(map));
      from = to;
    }
    return maps;
  }

 private:
  void observe_body(std::size_t index, const VectorXd& x, const MotionSample& u) {
    const PlannedBody& planned = plan_.bodies[index];
    const Body& body = planned.model.body;
    const VectorXd q = planned.coordinates.basis * x + planned.coordinates.carried * u.displacement;
    double slope_squared = 0.0, mean_squared = 0.0, turn_squared = 0.0;
    const std::size_t nodes = planned.model.arc_length.size();
    for (std::size_t node = 0; node < nodes; ++node) {
      const Eigen::Vector3d tangent = body.centreline.at(planned.model.arc_length[node]).tangent;
      const Eigen::Vector3d rotation = q.segment<3>(planned.model.node_dof(static_cast<int>(node)) + 3);
      const double squared = (rotation - rotation.dot(tangent) * tangent).squaredNorm();
      slope_squared = std::max(slope_squared, squared);
      mean_squared += squared / static_cast<double>(nodes);
      if (node == 0) continue;
      const Eigen::Vector3d turn = rotation - q.segment<3>(6 * static_cast<long>(node) - 3);
      turn_squared = std::max(turn_squared, (turn - turn.dot(tangent) * tangent).squaredNorm());
    }
    SimulatedBody& seen = bodies_[index];
    seen.largest_slope = std::max(seen.largest_slope, std::sqrt(slope_squared));
    // Mean curvature of an element times the radius, 2 sqrt(I/A) of a solid circle.
    const double element = planned.model.arc_length[1];
    const double radius = 2.0 * std::sqrt(body.section.second_moment / body.section.area);
    seen.largest_bending_strain =
        std::max(seen.largest_bending_strain, std::sqrt(turn_squared) / element * radius);
    // Straight and held at both ends: the deflected line is longer by the mean of slope^2/2.
    if (!body.centreline.is_straight() || body.start == EndCondition::free || body.end == EndCondition::free)
      return;
    const double length = body.centreline.length();
    const double euler_strain = 4.0 * std::numbers::pi * std::numbers::pi * body.section.second_moment /
                                (body.section.area * length * length);
    seen.stretch_stiffening = std::max(seen.stretch_stiffening, 0.5 * mean_squared / euler_strain);
  }

  const SimulationPlan& plan_;
  long per_bin_ = 1;
  long bins_seen_ = 0;
  double bin_interval_ = 0.0;
  Eigen::MatrixXd penetration_, force_;
  std::vector<SimulatedBody> bodies_;
};

/// Whether linear bodies can reach each other's walls.
class GapWatch {
 public:
  explicit GapWatch(const SimulationPlan& plan) : plan_(plan) {}
  /// Largest |h|/gap of the state.
  double reach(const Stepper& stepper, const MotionSample& u) const {
    std::vector<VectorXd> x;
    for (std::size_t b = 0; b < plan_.bodies.size(); ++b)
      x.push_back(stepper.displacement(static_cast<int>(b)));
    double largest = 0.0;
    for (const auto& point : plan_.points) {
      const Eigen::Vector2d h = point.rest_offset + point.motion * u.displacement +
                                point.inside.transpose() * x[static_cast<std::size_t>(point.inside_body)] -
                                point.outside.transpose() * x[static_cast<std::size_t>(point.outside_body)];
      largest = std::max(largest, h.norm() / point.gap);
    }
    return largest;
  }

 private:
  const SimulationPlan& plan_;
};

/// A linear run counts as clear of the gaps below this |h|/gap.
constexpr double clear_reach = 0.97;

}  // namespace

RunEnd run(Stepper& stepper, const SimulationPlan& plan, const MaxwellLaw& law, const MotionHistory& motion,
           const Sampling& sampling, bool contact, const SimulationProgress& progress,
           TimeResponse& response) {
  OutputReader reader(plan, law, motion.at(0.0));
  Observer observer(plan, sampling);
  const GapWatch watch(plan);
  Decimator decimator(sampling.filter ? sampling.oversampling : 1);
  std::vector<VectorXd> kept;
  RunEnd end = RunEnd::complete;
  const long lasting = static_cast<long>(std::floor(motion.duration() / sampling.interval() + 1e-6)) + 1;
  const long fine = std::min(sampling.samples * sampling.oversampling, lasting);
  double reach = 0.0;
  for (long i = 0; i < fine; ++i) {
    const double t = std::min(static_cast<double>(i) * sampling.interval(), motion.duration());
    if (i > 0) stepper.advance(t);
    const MotionSample u = motion.at(t);
    VectorXd y(1 + static_cast<long>(plan.rows.size()));
    y << u.displacement, reader.read(stepper, u, i > 0 ? sampling.interval() : 0.0, contact);
    if (sampling.filter || i % sampling.oversampling == 0) decimator.push(y, kept);
    if (contact) {
      observer.contact(i, stepper);
      if (i == 0) response.report.start_penetration = std::max(0.0, observer.deepest());
    } else if (!plan.points.empty()) {
      reach = std::max(reach, watch.reach(stepper, u));
      if (reach >= clear_reach) {
        end = RunEnd::gap_closed;
        break;
      }
    }
    observer.shapes(i, stepper, u);
    if (progress && i % 64 == 0 && !progress(t)) {
      end = RunEnd::interrupted;
      break;
    }
  }
  decimator.finish(kept);
  const auto count = static_cast<long>(kept.size());
  response.sample_interval = 1.0 / sampling.rate;
  response.motion.resize(count);
  response.output.resize(count, static_cast<long>(plan.rows.size()));
  for (long n = 0; n < count; ++n) {
    const VectorXd& y = kept[static_cast<std::size_t>(n)];
    response.motion[n] =
        sampling.filter_motion ? y[0] : motion.at(static_cast<double>(n) / sampling.rate).displacement;
    response.output.row(n) = y.tail(y.size() - 1).transpose();
  }
  if (contact) response.contacts = observer.maps();
  response.report.largest_offset = reach;
  response.report.bodies = observer.bodies();
  response.report.steps = stepper.steps();
  response.report.energy = stepper.energy();
  response.report.oversampling = sampling.filter ? sampling.oversampling : 1;
  return end;
}

}  // namespace struna::fem
