#include "ident/transfer_function_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "fem/error.hpp"
#include "ident/atomic_file.hpp"
#include "ident/csv.hpp"

namespace struna::ident {
namespace {

/// An output's columns in the file, -1 where it has none.
struct Columns {
  std::string name;
  std::string unit;
  int re = -1;
  int im = -1;
  int coherence = -1;
  int sigma = -1;
};

const std::string& unit_of_column(const CsvReader& csv, int column) {
  return csv.header()[static_cast<std::size_t>(column)].unit;
}

void require_unit(const CsvReader& csv, int column, const std::string& unit) {
  if (column >= 0 && unit_of_column(csv, column) != unit)
    throw Error(
        csv.file(), 1,
        fmt::format("column '{}' has the unit '{}', its real part '{}': they must be the same",
                    csv.header()[static_cast<std::size_t>(column)].name, unit_of_column(csv, column), unit));
}

/// `prefix` is "NAME_", or empty for bare columns.
Columns columns_with(const CsvReader& csv, const std::string& prefix) {
  Columns columns;
  columns.name = prefix.empty() ? "output" : prefix.substr(0, prefix.size() - 1);
  columns.re = csv.column(prefix + "re");
  columns.im = csv.column(prefix + "im");
  columns.coherence = csv.find(prefix + "coherence");
  columns.sigma = csv.find(prefix + "sigma");
  columns.unit = unit_of_column(csv, columns.re);
  require_unit(csv, columns.im, columns.unit);
  require_unit(csv, columns.sigma, columns.unit);
  return columns;
}

std::vector<Columns> find_outputs(const CsvReader& csv) {
  std::vector<Columns> outputs;
  for (const auto& header : csv.header()) {
    if (header.name == "re") outputs.push_back(columns_with(csv, ""));
    if (header.name.size() > 3 && header.name.ends_with("_re"))
      outputs.push_back(columns_with(csv, header.name.substr(0, header.name.size() - 2)));
    if (header.name == "im" || (header.name.size() > 3 && header.name.ends_with("_im")))
      csv.column(header.name.substr(0, header.name.size() - 2) +
                 "re");  // an error where the real part is missing
  }
  if (outputs.empty())
    throw Error(csv.file(), 1,
                "no transfer function: columns 'NAME_re [unit]' and 'NAME_im [unit]' (or re, im) are needed");
  return outputs;
}

void require_hz(const CsvReader& csv, int column) {
  if (unit_of_column(csv, column) != "Hz")
    throw Error(
        csv.file(), 1,
        fmt::format("the unit of {} is '{}': it must be Hz",
                    csv.header()[static_cast<std::size_t>(column)].name, unit_of_column(csv, column)));
}

int frequency_column(const CsvReader& csv) {
  const int column = csv.column("frequency");
  require_hz(csv, column);
  return column;
}

TransferFunction::Output named_output(const CsvReader& csv, const Columns& columns,
                                      std::vector<std::string>* warnings) {
  TransferFunction::Output output;
  output.name = columns.name;
  output.unit = columns.unit;
  output.kind = kind_of_unit(columns.unit);
  if (output.kind == FrfKind::unknown && warnings)
    warnings->push_back(
        fmt::format("{}: the unit '{}' of output '{}' is not understood: it is carried through, and its form "
                    "cannot be changed",
                    csv.file(), columns.unit, columns.name));
  return output;
}

/// The numbers of a row, in the order of the columns asked for.
class Rows {
 public:
  Rows(CsvReader& csv, std::vector<int> columns) : csv_(csv), columns_(std::move(columns)) {}

  bool next() {
    if (!csv_.next(fields_)) return false;
    for (const int column : columns_) numbers_.push_back(column < 0 ? 0.0 : csv_.number(fields_, column));
    return true;
  }
  long count() const { return static_cast<long>(numbers_.size() / columns_.size()); }
  double last(long column) const {
    return numbers_[numbers_.size() - columns_.size() + static_cast<std::size_t>(column)];
  }
  Eigen::Map<const Eigen::VectorXd, 0, Eigen::InnerStride<>> column(long index) const {
    return {numbers_.data() + index, count(), Eigen::InnerStride<>(static_cast<long>(columns_.size()))};
  }

 private:
  CsvReader& csv_;
  std::vector<int> columns_;
  std::vector<std::string_view> fields_;
  std::vector<double> numbers_;
};

constexpr long columns_per_output = 4;

/// What every row repeats, in columns before the outputs'.
struct Common {
  double exponential_decay = 0.0;
  double leakage_hz = 0.0;
};
constexpr long first_output = 3;

void check_row(const CsvReader& csv, const Rows& rows, double previous_frequency, const Common& common,
               long outputs) {
  const auto refuse = [&csv](const std::string& what) { throw Error(csv.file(), csv.line(), what); };
  if (rows.last(0) < 0.0) refuse(fmt::format("frequency {} Hz is negative", rows.last(0)));
  if (rows.count() > 1 && rows.last(0) <= previous_frequency)
    refuse(fmt::format("frequency {} Hz follows {} Hz: frequencies must increase", rows.last(0),
                       previous_frequency));
  if (rows.last(1) < 0.0 || rows.last(1) != common.exponential_decay)
    refuse(fmt::format("exponential_decay is {}: it must be at least 0 and the same in every row",
                       rows.last(1)));
  if (rows.last(2) < 0.0 || rows.last(2) != common.leakage_hz)
    refuse(fmt::format("leakage is {}: it must be at least 0 and the same in every row", rows.last(2)));
  for (long k = 0; k < outputs; ++k) {
    const double coherence = rows.last(first_output + columns_per_output * k + 2);
    const double sigma = rows.last(first_output + columns_per_output * k + 3);
    if (coherence < 0.0 || coherence > 1.0)
      refuse(fmt::format("coherence is {}: it must be in [0, 1]", coherence));
    if (sigma < 0.0) refuse(fmt::format("sigma is {}: it must not be negative", sigma));
  }
}

}  // namespace

TransferFunction read_transfer_function(const std::string& file, std::vector<std::string>* warnings) {
  CsvReader csv(file);
  const std::vector<Columns> outputs = find_outputs(csv);
  const int leakage = csv.find("leakage");
  if (leakage >= 0) require_hz(csv, leakage);
  std::vector<int> wanted{frequency_column(csv), csv.find("exponential_decay"), leakage};
  for (const Columns& columns : outputs)
    wanted.insert(wanted.end(), {columns.re, columns.im, columns.coherence, columns.sigma});
  Rows rows(csv, wanted);
  double previous = 0.0;
  Common common;
  while (rows.next()) {
    if (rows.count() == 1) common = {rows.last(1), rows.last(2)};
    check_row(csv, rows, previous, common, static_cast<long>(outputs.size()));
    previous = rows.last(0);
  }
  if (rows.count() == 0) throw Error(file, 0, "has no lines below its header");

  TransferFunction tf;
  tf.frequency_hz = rows.column(0);
  tf.exponential_decay = common.exponential_decay;
  if (leakage >= 0) tf.leakage_hz = common.leakage_hz;
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    const long first = first_output + columns_per_output * static_cast<long>(k);
    auto output = named_output(csv, outputs[k], warnings);
    output.value.resize(rows.count());
    output.value.real() = rows.column(first);
    output.value.imag() = rows.column(first + 1);
    if (outputs[k].coherence >= 0) output.coherence = rows.column(first + 2);
    if (outputs[k].sigma >= 0) output.sigma = rows.column(first + 3);
    tf.outputs.push_back(std::move(output));
  }
  return tf;
}

void write_transfer_function(const TransferFunction& tf, const std::string& file) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "frequency [Hz]");
  for (const auto& output : tf.outputs) {
    const bool finite = output.value.allFinite() && output.coherence.allFinite() && output.sigma.allFinite();
    if (!finite || output.value.size() != tf.lines())
      throw Error(
          fmt::format("write_transfer_function: output '{}' needs a finite value at each of the {} lines",
                      output.name, tf.lines()));
    fmt::format_to(out, ",{0}_re [{1}],{0}_im [{1}]", output.name, output.unit);
    if (output.coherence.size() > 0) fmt::format_to(out, ",{}_coherence [-]", output.name);
    if (output.sigma.size() > 0) fmt::format_to(out, ",{}_sigma [{}]", output.name, output.unit);
  }
  const bool decays = tf.exponential_decay > 0.0, leakage_known = std::isfinite(tf.leakage_hz);
  fmt::format_to(out, "{}{}\n", decays ? ",exponential_decay [1/s]" : "",
                 leakage_known ? ",leakage [Hz]" : "");
  for (long i = 0; i < tf.lines(); ++i) {
    fmt::format_to(out, "{:.13g}", tf.frequency_hz[i]);
    for (const auto& output : tf.outputs) {
      fmt::format_to(out, ",{:.13g},{:.13g}", output.value[i].real(), output.value[i].imag());
      if (output.coherence.size() > 0) fmt::format_to(out, ",{:.9g}", output.coherence[i]);
      if (output.sigma.size() > 0) fmt::format_to(out, ",{:.9g}", output.sigma[i]);
    }
    if (decays) fmt::format_to(out, ",{:.17g}", tf.exponential_decay);
    if (leakage_known) fmt::format_to(out, ",{:.17g}", tf.leakage_hz);
    fmt::format_to(out, "\n");
  }
  write_atomically(file, std::string_view(text.data(), text.size()));
}

}  // namespace struna::ident
