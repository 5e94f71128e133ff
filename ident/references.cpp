#include "ident/references.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "fem/error.hpp"
#include "fem/scene.hpp"

namespace struna::ident {
namespace {

constexpr double same_line = 1e-3;    // of a line spacing
constexpr double least_shared = 0.5;  // of the lines in the common band

long place_of(const std::string& name, std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return found - names.begin();
  names.push_back(name);
  return static_cast<long>(names.size()) - 1;
}

void check_names(const std::vector<NamedReference>& references) {
  for (std::size_t j = 0; j < references.size(); ++j) {
    const std::string& name = references[j].name;
    if (name.empty() || name.find_first_of("@, \t\"") != std::string::npos)
      throw Error(references[j].file, 0,
                  fmt::format("'{}' cannot name a reference: letters, digits, '-', '_' or '.' are needed, "
                              "such as the direction y",
                              name));
    for (std::size_t i = 0; i < j; ++i)
      if (references[i].name == name)
        throw Error(references[j].file, 0,
                    fmt::format("is the second reference named '{}': each needs a name of its own", name));
  }
}

void check_alike(const NamedReference& first, const NamedReference& other) {
  const auto names = output_names(first.function), others = output_names(other.function);
  if (names != others)
    throw Error(other.file, 0,
                fmt::format("has outputs {} but reference '{}' has {}: all references need the same outputs "
                            "in one order",
                            fmt::join(others, ", "), first.name, fmt::join(names, ", ")));
  for (std::size_t k = 0; k < names.size(); ++k)
    if (first.function.outputs[k].unit != other.function.outputs[k].unit)
      throw Error(other.file, 0,
                  fmt::format("{} is in {} but in {} under reference '{}': give all one form", names[k],
                              other.function.outputs[k].unit, first.function.outputs[k].unit, first.name));
  if (first.function.exponential_decay != other.function.exponential_decay)
    throw Error(other.file, 0,
                fmt::format("an exponential window adds {:.6g} 1/s to the decay, {:.6g} 1/s under reference "
                            "'{}': give all the same window and duration",
                            other.function.exponential_decay, first.function.exponential_decay, first.name));
}

double spacing_of(const TransferFunction& tf) {
  return (tf.frequency_hz(tf.lines() - 1) - tf.frequency_hz(0)) /
         std::max(1.0, static_cast<double>(tf.lines() - 1));
}

/// The line of `tf` at this frequency, -1 where there is none.
long line_at(const TransferFunction& tf, double f_hz, double tolerance_hz) {
  const auto begin = tf.frequency_hz.data(), end = begin + tf.lines();
  const auto at = std::lower_bound(begin, end, f_hz - tolerance_hz);
  return at != end && *at <= f_hz + tolerance_hz ? at - begin : -1;
}

/// Rows of lines, one column per reference, that all of them have.
std::vector<std::vector<long>> shared_lines(const std::vector<NamedReference>& references) {
  const TransferFunction& first = references.front().function;
  const double tolerance = same_line * spacing_of(first);
  std::vector<std::vector<long>> shared;
  double lo = 0.0, hi = 1e300;
  for (const auto& reference : references) {
    const Eigen::VectorXd& f = reference.function.frequency_hz;
    if (f.size() == 0) throw Error(reference.file, 0, "has no lines");
    lo = std::max(lo, f(0));
    hi = std::min(hi, f(f.size() - 1));
  }
  for (long i = 0; i < first.lines(); ++i) {
    std::vector<long> row;
    for (const auto& reference : references)
      row.push_back(line_at(reference.function, first.frequency_hz(i), tolerance));
    if (std::count(row.begin(), row.end(), -1) == 0) shared.push_back(std::move(row));
  }
  for (const auto& reference : references) {
    const auto& f = reference.function.frequency_hz;
    const long inside = std::count_if(f.begin(), f.end(), [&](double v) { return v >= lo && v <= hi; });
    if (static_cast<double>(shared.size()) < std::max(1.0, least_shared * static_cast<double>(inside)))
      throw Error(reference.file, 0,
                  fmt::format("its lines, every {:.6g} Hz, are not those of reference '{}', every {:.6g} Hz: "
                              "estimate all with one --resolution and band",
                              spacing_of(reference.function), references.front().name, spacing_of(first)));
  }
  return shared;
}

template <class Vector>
Vector picked(const Vector& all, const std::vector<std::vector<long>>& rows, std::size_t column) {
  if (all.size() == 0) return all;
  Vector few(static_cast<long>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) few(static_cast<long>(i)) = all(rows[i][column]);
  return few;
}

}  // namespace

References references_of(const std::vector<std::string>& output_names) {
  References result;
  std::vector<std::pair<long, long>> at;
  for (const std::string& name : output_names) {
    const auto mark = name.rfind(fem::reference_mark);
    const std::string reference = mark == std::string::npos ? "" : name.substr(mark + 1);
    const long output = place_of(name.substr(0, mark), result.outputs);
    at.emplace_back(output, place_of(reference, result.names));
  }
  result.column.setConstant(static_cast<long>(result.outputs.size()), static_cast<long>(result.names.size()),
                            -1);
  for (std::size_t k = 0; k < at.size(); ++k) result.column(at[k].first, at[k].second) = static_cast<int>(k);
  return result;
}

std::vector<std::string> output_names(const TransferFunction& tf) {
  std::vector<std::string> names;
  for (const auto& output : tf.outputs) names.push_back(output.name);
  return names;
}

TransferFunction combine_references(const std::vector<NamedReference>& references) {
  if (references.empty()) throw Error("combine_references: at least one reference, got none");
  const NamedReference& first = references.front();
  if (references.size() == 1) return first.function;
  check_names(references);
  for (const auto& reference : references) {
    check_alike(first, reference);
    for (const auto& output : reference.function.outputs)
      if (output.name.find(fem::reference_mark) != std::string::npos)
        throw Error(reference.file, 0,
                    fmt::format("{} is already one of several references: give the file alone", output.name));
  }
  const auto rows = shared_lines(references);
  TransferFunction all;
  all.exponential_decay = first.function.exponential_decay;
  all.leakage_hz = first.function.leakage_hz;
  for (const auto& reference : references)  // unknown, once one of them is
    if (!(reference.function.leakage_hz <= all.leakage_hz) && !std::isnan(all.leakage_hz))
      all.leakage_hz = reference.function.leakage_hz;
  all.frequency_hz = picked(first.function.frequency_hz, rows, 0);
  for (std::size_t j = 0; j < references.size(); ++j)
    for (TransferFunction::Output output : references[j].function.outputs) {
      if (j > 0) output.name += fem::reference_mark + references[j].name;
      output.value = picked(output.value, rows, j);
      output.coherence = picked(output.coherence, rows, j);
      output.sigma = picked(output.sigma, rows, j);
      all.outputs.push_back(std::move(output));
    }
  return all;
}

}  // namespace struna::ident
