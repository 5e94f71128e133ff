#include "apps/tradeoff_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "fem/beam_element.hpp"

namespace struna::apps {
namespace {

constexpr long lines = 400;

/// Adds a part that begins at dof `first` to the lower half of a band matrix.
template <class Part>
void add(fem::BandMatrix& matrix, long first, const Part& part) {
  for (long j = 0; j < part.cols(); ++j) {
    matrix.lower.col(first + j).head(part.rows() - j) += part.col(j).tail(part.rows() - j);
  }
}

/// Both nodes of an element in turn: half its mass, and inertia against rotation about axes along and across
/// the tangent there.
void add_lumped_mass(const fem::Body& body, long first, double length, const Eigen::Vector3d& tangent,
                     fem::BandMatrix& mass) {
  const double total = body.density * body.section.area * length;
  const double polar = body.density * 2.0 * body.section.second_moment * length;
  const Eigen::Matrix3d along = tangent * tangent.transpose();
  const Eigen::Matrix3d translation = 0.5 * total * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d rotation =
      total * length * length / 78.0 * (Eigen::Matrix3d::Identity() - along) + 0.5 * polar * along;
  add(mass, first, translation);
  add(mass, first + 3, rotation);
}

std::string kind_name(MeshKind kind, bool straight) {
  const bool lumped = kind == MeshKind::curved_lumped || kind == MeshKind::chords_lumped;
  const bool chords = kind == MeshKind::chords_consistent || kind == MeshKind::chords_lumped;
  const std::string mass = lumped ? "lumped mass" : "consistent mass";
  return (straight ? "straight elements; " : chords ? "straight chords; " : "curved elements; ") + mass;
}

std::vector<MeshKind> kinds_for(const fem::Body& body) {
  if (body.centreline.is_straight()) return {MeshKind::curved_consistent, MeshKind::curved_lumped};
  return {MeshKind::curved_consistent, MeshKind::chords_consistent, MeshKind::curved_lumped,
          MeshKind::chords_lumped};
}

std::vector<int> element_counts(int usual, int usual_in_response) {
  std::vector<int> counts = {8, 12, 16, 24, 32, 48, 64, 96, usual, usual_in_response};
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  return counts;
}

TradeoffChart chart_of(const LinearProblem& problem, const std::string& quantity,
                       const LinearReference& reference) {
  TradeoffChart chart;
  chart.stage = "model";
  chart.problem = problem.name;
  chart.quantity = quantity;
  chart.reference = reference.text;
  return chart;
}

}  // namespace

fem::Model tradeoff_mesh(const fem::Body& body, int elements, MeshKind kind) {
  fem::Model model = fem::assemble(body, elements);
  const bool chords = kind == MeshKind::chords_consistent || kind == MeshKind::chords_lumped;
  const bool lumped = kind == MeshKind::curved_lumped || kind == MeshKind::chords_lumped;
  if (chords) model.stiffness.lower.setZero();
  if (chords || lumped) model.mass.lower.setZero();
  for (int i = 0; (chords || lumped) && i < elements; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const Eigen::Vector3d chord = model.position[at + 1] - model.position[at];
    const double length = chords ? chord.norm() : model.arc_length[at + 1] - model.arc_length[at];
    if (chords) {
      const auto part = fem::straight_beam_element(body, length, chord / length);
      add(model.stiffness, 6L * i, part.stiffness);
      if (!lumped) add(model.mass, 6L * i, part.mass);
    }
    for (int node = 0; lumped && node < 2; ++node) {
      const Eigen::Vector3d tangent =
          chords ? Eigen::Vector3d(chord / length)
                 : body.centreline.at(model.arc_length[at + static_cast<std::size_t>(node)]).tangent;
      add_lumped_mass(body, 6L * (i + node), length, tangent, model.mass);
    }
  }
  return model;
}

std::vector<TradeoffChart> tradeoff_model(const LinearProblem& problem, const TradeoffRun& run) {
  run.progress(fmt::format("model: {}, reference", problem.name));
  const LinearReference reference = linear_reference(problem, lines);
  const auto modes = static_cast<int>(reference.natural_frequency_hz.size());
  TradeoffChart frequency = chart_of(problem, "natural frequencies", reference);
  frequency.error_label =
      fmt::format("largest relative error of the {} up to {:g} Hz", modes, problem.band.hi_hz);
  frequency.reference_error = reference.frequency_error;
  frequency.target = 1e-3;
  TradeoffChart response = chart_of(problem, "transfer function", reference);
  response.error_label = fmt::format("relative rms over {} lines from {:g} to {:g} Hz, worst output", lines,
                                     problem.band.lo_hz, problem.band.hi_hz);
  response.reference_error = reference.response_error;
  const int usual = default_elements(problem, fem::SizingTarget::natural_frequencies);
  const int usual_in_response = default_elements(problem, fem::SizingTarget::response);
  for (const MeshKind kind : kinds_for(problem.body)) {
    const std::string name = kind_name(kind, problem.body.centreline.is_straight());
    for (const int elements : element_counts(usual, usual_in_response)) {
      run.progress(fmt::format("model: {}, {}, {} elements", problem.name, name, elements));
      fem::Model model = tradeoff_mesh(problem.body, elements, kind);
      if (static_cast<int>(model.free_dof.size()) < modes) continue;
      const bool as_built = kind == MeshKind::curved_consistent;
      TradeoffRow row{
          name, "elements [-]", static_cast<double>(elements), 0.0, 0.0, as_built && elements == usual,
          false};
      Eigen::VectorXd eigenvalue;
      row.seconds = best_seconds(run.timing, [&] {
        eigenvalue = fem::solve_eigenmodes(tradeoff_mesh(problem.body, elements, kind), modes).eigenvalue;
      });
      row.error = frequency_error(fem::natural_frequencies_hz(problem.body, eigenvalue),
                                  reference.natural_frequency_hz);
      frequency.rows.push_back(row);
      Eigen::MatrixXcd values;
      row.seconds = best_seconds(run.timing, [&] {
        values = fem::harmonic_response(tradeoff_mesh(problem.body, elements, kind), problem.drive,
                                        problem.measurement, reference.line_hz, {problem.damping, false})
                     .response;
      });
      row.error = response_error(values, reference.response);
      row.is_default = as_built && elements == usual_in_response;
      response.rows.push_back(row);
    }
  }
  mark_pareto(frequency);
  mark_pareto(response);
  return {frequency, response};
}

std::vector<TradeoffChart> tradeoff_model(const TradeoffRun& run) {
  std::vector<TradeoffChart> charts = tradeoff_model(straight_wire_problem(), run);
  for (auto& chart : tradeoff_model(spline_wire_problem(), run)) charts.push_back(std::move(chart));
  return charts;
}

}  // namespace struna::apps
