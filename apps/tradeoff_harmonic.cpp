#include "apps/tradeoff_harmonic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "fem/band_cholesky.hpp"
#include "fem/error.hpp"

namespace struna::apps {
namespace {

using Complex = std::complex<double>;

/// Lines that `struna predict` writes when nothing is said: every 0.5 Hz.
constexpr double line_spacing_hz = 0.5;

/// Factors of K1 and M in the dynamic stiffness at a line.
struct Scales {
  Complex stiffness;
  Complex mass;
};

Scales scales_at(const LinearProblem& problem, double f_hz) {
  const fem::Material& material = problem.body.material;
  const double omega = 2.0 * std::numbers::pi * f_hz;
  const double modulus = material.youngs_modulus.at(f_hz);
  if (problem.damping == fem::Damping::structural)
    return {modulus * Complex(1.0, material.loss_factor.at(f_hz)), -omega * omega};
  return {modulus * Complex(1.0, omega * material.rayleigh.beta),
          Complex(-omega * omega, omega * material.rayleigh.alpha)};
}

const fem::SupportMotion& support_drive(const LinearProblem& problem) {
  const auto* const drive = std::get_if<fem::SupportMotion>(&problem.drive);
  if (drive == nullptr || !std::holds_alternative<fem::SupportForce>(problem.measurement.what)) {
    throw Error("modal_response: the drive must be a support's motion and the measurement a support's force");
  }
  return *drive;
}

/// A translation of supports over all dof.
Eigen::VectorXd support_vector(const fem::Model& model, const std::vector<fem::End>& ends,
                               const Eigen::Vector3d& direction) {
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(model.dof_count());
  for (const fem::End end : ends) unit.segment<3>(fem::first_dof(model, end)) = direction;
  return unit;
}

/// The columns of support motions with what the free dof do at rest: K1 S = 0 there.
Eigen::MatrixXd static_shapes(const fem::Model& model, const Eigen::MatrixXd& moved) {
  const fem::BandMatrix free = fem::submatrix(model.stiffness, model.free_dof);
  fem::BandCholesky factor;
  if (!factor.factorise(free, 1.0, free, 0.0))
    throw Error("modal_response: body '" + model.body.name +
                "' is not held; both ends free have no static shape");
  Eigen::MatrixXd shapes = moved;
  const Eigen::MatrixXd load = fem::multiply(model.stiffness, moved);
  for (long k = 0; k < moved.cols(); ++k) {
    Eigen::VectorXd x = -load.col(k)(model.free_dof);
    factor.solve(x);
    for (std::size_t i = 0; i < model.free_dof.size(); ++i)
      shapes(model.free_dof[i], k) += x(static_cast<long>(i));
  }
  return shapes;
}

/// Everything of a modal sum that does not depend on frequency: y = -(s_k in_k + s_m in_m)/(s_k lambda +
/// s_m), H = s_k direct_k + s_m direct_m + (s_k out_k + s_m out_m) y.
struct ModalTerms {
  Eigen::ArrayXd eigenvalue;
  Eigen::ArrayXd in_k, in_m;
  Eigen::MatrixXd out_k, out_m;  ///< outputs x modes
  Eigen::VectorXd direct_k, direct_m;
};

ModalTerms modal_terms(const LinearProblem& problem, const fem::Model& model, int modes, ModalSum sum) {
  const fem::SupportMotion& drive = support_drive(problem);
  const auto& force = std::get<fem::SupportForce>(problem.measurement.what);
  const auto outputs = static_cast<long>(problem.measurement.directions.size());
  // Column 0: the driven support; the others: the measured one along each direction.
  Eigen::MatrixXd unit(model.dof_count(), outputs + 1);
  unit.col(0) = support_vector(model, drive.ends, drive.direction);
  for (long k = 0; k < outputs; ++k) {
    unit.col(k + 1) =
        support_vector(model, {force.end}, problem.measurement.directions[static_cast<std::size_t>(k)]);
  }
  if (sum == ModalSum::static_correction) unit = static_shapes(model, unit);
  const Eigen::MatrixXd k = fem::multiply(model.stiffness, unit);
  const Eigen::MatrixXd m = fem::multiply(model.mass, unit);
  const fem::Eigenmodes found = fem::solve_eigenmodes(model, modes);
  ModalTerms terms;
  terms.eigenvalue = found.eigenvalue;
  const Eigen::MatrixXd on_m = m.transpose() * found.shape;
  Eigen::MatrixXd on_k = k.transpose() * found.shape;
  if (sum == ModalSum::static_correction) on_k.setZero();  // K1 S vanishes on the free dof
  terms.in_k = on_k.row(0);
  terms.in_m = on_m.row(0);
  terms.out_k = on_k.bottomRows(outputs);
  terms.out_m = on_m.bottomRows(outputs);
  terms.direct_k = unit.rightCols(outputs).transpose() * k.col(0);
  terms.direct_m = unit.rightCols(outputs).transpose() * m.col(0);
  return terms;
}

std::vector<int> element_counts(int usual) {
  std::vector<int> counts = {16, 24, 32, 48, 64, 96, 128, usual};
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  return counts;
}

bool has_modal_sum(const LinearProblem& problem) {
  return std::holds_alternative<fem::SupportMotion>(problem.drive) &&
         std::holds_alternative<fem::SupportForce>(problem.measurement.what);
}

void add_modal_rows(const LinearProblem& problem, const LinearReference& reference, int elements,
                    ModalSum sum, const TradeoffRun& run, TradeoffChart& chart) {
  const std::string name =
      fmt::format("modal; {}; {} elements",
                  sum == ModalSum::plain ? "no static correction" : "static correction", elements);
  const int all = static_cast<int>(fem::assemble(problem.body, elements).free_dof.size());
  for (const int modes : {16, 32, 48, 64, 96, all}) {
    if (modes > all) continue;
    run.progress(fmt::format("harmonic: {}, {}, {} modes", problem.name, name, modes));
    TradeoffRow row{name, "modes kept [-]", static_cast<double>(modes)};
    Eigen::MatrixXcd response;
    row.seconds = best_seconds(run.timing, [&] {
      response =
          modal_response(problem, fem::assemble(problem.body, elements), modes, sum, reference.line_hz);
    });
    row.error = response_error(response, reference.response);
    chart.rows.push_back(row);
  }
}

}  // namespace

Eigen::MatrixXcd modal_response(const LinearProblem& problem, const fem::Model& model, int modes,
                                ModalSum sum, const Eigen::VectorXd& line_hz) {
  const ModalTerms terms = modal_terms(problem, model, modes, sum);
  Eigen::MatrixXcd response(line_hz.size(), terms.direct_k.size());
  Eigen::ArrayXcd y(terms.eigenvalue.size());
  for (long line = 0; line < line_hz.size(); ++line) {
    const Scales s = scales_at(problem, line_hz(line));
    y = -(s.stiffness * terms.in_k.cast<Complex>() + s.mass * terms.in_m.cast<Complex>()) /
        (s.stiffness * terms.eigenvalue.cast<Complex>() + s.mass);
    for (long k = 0; k < response.cols(); ++k) {
      const Complex along_k(terms.out_k.row(k).dot(y.real().matrix()),
                            terms.out_k.row(k).dot(y.imag().matrix()));
      const Complex along_m(terms.out_m.row(k).dot(y.real().matrix()),
                            terms.out_m.row(k).dot(y.imag().matrix()));
      response(line, k) =
          s.stiffness * (terms.direct_k(k) + along_k) + s.mass * (terms.direct_m(k) + along_m);
    }
  }
  return response;
}

std::vector<TradeoffChart> tradeoff_harmonic(const LinearProblem& problem, const TradeoffRun& run) {
  run.progress(fmt::format("harmonic: {}, reference", problem.name));
  const auto lines =
      static_cast<long>(std::min((problem.band.hi_hz - problem.band.lo_hz) / line_spacing_hz, 4000.0)) + 1;
  const LinearReference reference = response_reference(problem, lines);
  TradeoffChart chart;
  chart.stage = "harmonic";
  chart.problem = problem.name;
  chart.quantity = "transfer function";
  chart.error_label = fmt::format("relative rms over {} lines from {:g} to {:g} Hz, worst output", lines,
                                  problem.band.lo_hz, problem.band.hi_hz);
  chart.reference = reference.text;
  chart.reference_error = reference.response_error;
  const int usual = default_elements(problem, fem::SizingTarget::response);
  for (const int elements : element_counts(usual)) {
    run.progress(fmt::format("harmonic: {}, direct, {} elements", problem.name, elements));
    TradeoffRow row{"direct",          "elements [-]", static_cast<double>(elements), 0.0, 0.0,
                    elements == usual, false};
    Eigen::MatrixXcd response;
    row.seconds = best_seconds(run.timing, [&] {
      response = fem::harmonic_response(fem::assemble(problem.body, elements), problem.drive,
                                        problem.measurement, reference.line_hz, {problem.damping, false})
                     .response;
    });
    row.error = response_error(response, reference.response);
    chart.rows.push_back(row);
  }
  if (has_modal_sum(problem)) {
    add_modal_rows(problem, reference, usual, ModalSum::static_correction, run, chart);
    add_modal_rows(problem, reference, 5 * usual / 4, ModalSum::static_correction, run, chart);
    add_modal_rows(problem, reference, usual, ModalSum::plain, run, chart);
  } else {
    chart.notes.push_back("Modal sums are charted for a support's force over a support's motion only.");
  }
  mark_pareto(chart);
  return {chart};
}

std::vector<TradeoffChart> tradeoff_harmonic(const TradeoffRun& run) {
  std::vector<TradeoffChart> charts = tradeoff_harmonic(straight_wire_problem(), run);
  for (auto& chart : tradeoff_harmonic(spline_wire_problem(), run)) charts.push_back(std::move(chart));
  return charts;
}

}  // namespace struna::apps
