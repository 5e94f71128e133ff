#include "fem/scene_stepper.hpp"

namespace struna::fem {
namespace {

using Eigen::VectorXd;

std::vector<ContactPoint> points_of(const SimulationPlan& plan, bool contact) {
  return contact ? plan.points : std::vector<ContactPoint>{};
}

class ModalRun final : public Stepper {
 public:
  ModalRun(const SimulationPlan& plan, std::vector<ModalBody> bodies, bool contact,
           const MotionHistory& motion, const ModalSteppingOptions& options, bool settled)
      : plan_(plan),
        bodies_(bodies),
        contact_(contact),
        stepper_(
            std::move(bodies), points_of(plan, contact), [motion](double t) { return motion.at(t); },
            options) {
    if (settled) stepper_.settle();
  }
  void advance(double time) override { stepper_.advance(time); }
  VectorXd displacement(int body) const override { return stepper_.displacement(body); }
  VectorXd velocity(int body) const override { return stepper_.velocity(body); }
  /// q'' = p - (elastic and damping force), contact included in p.
  VectorXd acceleration(int body, const MotionSample& u) const override {
    const ModalBody& modal = bodies_[static_cast<std::size_t>(body)];
    VectorXd p = modal.load * Eigen::Vector3d(u.displacement, u.velocity, u.acceleration);
    if (modal.constant_load.size() > 0) p += modal.constant_load;
    for (std::size_t i = 0; contact_ && i < plan_.points.size(); ++i) {
      const ContactPoint& point = plan_.points[i];
      if (point.inside_body != body && point.outside_body != body) continue;
      const Eigen::Vector2d f = force_on_inside(static_cast<int>(i));
      if (f.isZero(0.0)) continue;
      if (point.inside_body == body) p += point.inside * f;
      if (point.outside_body == body) p -= point.outside * f;
    }
    return p - stepper_.internal_force(body);
  }
  double penetration(int point) const override { return stepper_.penetration(point); }
  double force(int point) const override { return stepper_.force(point); }
  Eigen::Vector2d offset(int point) const override { return stepper_.offset(point); }
  StepReport steps() const override { return stepper_.report(); }
  std::optional<EnergyLedger> energy() const override { return stepper_.energy(); }

 private:
  const SimulationPlan& plan_;
  std::vector<ModalBody> bodies_;
  bool contact_;
  ModalStepper stepper_;
};

class NewmarkRun final : public Stepper {
 public:
  NewmarkRun(const SimulationPlan& plan, std::vector<NodalBody> bodies, bool contact,
             const MotionHistory& motion, const NewmarkOptions& options, bool settled)
      : stepper_(
            std::move(bodies), points_of(plan, contact), [motion](double t) { return motion.at(t); },
            options) {
    settled ? stepper_.settle() : stepper_.follow_base();
  }
  void advance(double time) override { stepper_.advance(time); }
  VectorXd displacement(int body) const override { return stepper_.displacement(body); }
  VectorXd velocity(int body) const override { return stepper_.velocity(body); }
  VectorXd acceleration(int body, const MotionSample&) const override { return stepper_.acceleration(body); }
  double penetration(int point) const override { return stepper_.penetration(point); }
  double force(int point) const override { return stepper_.force(point); }
  Eigen::Vector2d offset(int point) const override { return stepper_.offset(point); }
  StepReport steps() const override { return stepper_.report(); }
  std::optional<EnergyLedger> energy() const override { return std::nullopt; }

 private:
  NewmarkStepper stepper_;
};

}  // namespace

std::unique_ptr<Stepper> modal_run(const SimulationPlan& plan, std::vector<ModalBody> bodies, bool contact,
                                   const MotionHistory& motion, const ModalSteppingOptions& options,
                                   bool settled) {
  return std::make_unique<ModalRun>(plan, std::move(bodies), contact, motion, options, settled);
}

std::unique_ptr<Stepper> newmark_run(const SimulationPlan& plan, std::vector<NodalBody> bodies, bool contact,
                                     const MotionHistory& motion, const NewmarkOptions& options,
                                     bool settled) {
  return std::make_unique<NewmarkRun>(plan, std::move(bodies), contact, motion, options, settled);
}

}  // namespace struna::fem
