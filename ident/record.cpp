#include "ident/record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "fem/error.hpp"
#include "ident/atomic_file.hpp"
#include "ident/csv.hpp"

namespace struna::ident {
namespace {

/// Watches a time column: increasing, uniform.
class Clock {
 public:
  Clock(const CsvReader& csv, const std::string& file) {
    const auto& unit = csv.header()[static_cast<std::size_t>(csv.column("time"))].unit;
    if (unit.empty()) throw Error(file, 1, "the time column has no unit: write 'time [s]'");
    const Unit parsed = unit_in_header(file, unit);
    if (parsed.quantity != Quantity::time)
      throw Error(file, 1, fmt::format("the time column's unit is '{}': s, ms and us are understood", unit));
    to_si_ = parsed.to_si;
  }

  static Unit unit_in_header(const std::string& file, const std::string& unit) {
    try {
      return parse_unit(unit);
    } catch (const Error& error) {
      throw Error(file, 1, error.reason());
    }
  }

  /// `last_digit` is the power of ten of the last digit that the time was written with.
  void tick(const CsvReader& csv, double number, int last_digit) {
    const double time = number * to_si_;
    last_digit_ = last_digit;
    if (rows_ == 0) {
      start_ = time;
    } else {
      // Against the mean step so far, without a division per row.
      const double step = time - now_;
      const double steps = rows_ == 1 ? 1.0 : static_cast<double>(rows_ - 1);
      const double span = rows_ == 1 ? step : now_ - start_;
      if (!(step > 0.0) || std::abs(step * steps - span) > 0.01 * span)
        examine(csv, time, step, span / steps);
    }
    now_ = time;
    ++rows_;
  }

  long rows() const { return rows_; }
  double start() const { return start_; }
  /// The mean step, or the one of a whole number of samples per second where the written digits cannot tell
  /// them apart.
  double sample_interval() const {
    const double mean = mean_step();
    if (rows_ < 2 || mean > 1.0) return mean;
    const double whole = 1.0 / std::round(1.0 / mean);
    const double unresolved = written_resolution() / static_cast<double>(rows_ - 1);
    return std::abs(whole - mean) <= unresolved ? whole : mean;
  }

 private:
  double mean_step() const { return rows_ < 2 ? 0.0 : (now_ - start_) / static_cast<double>(rows_ - 1); }

  /// The place value of the last digit written [s].
  double written_resolution() const { return std::pow(10.0, last_digit_) * to_si_; }

  void examine(const CsvReader& csv, double time, double step, double expected) const {
    if (!(step > 0.0))
      throw Error(
          csv.file(), csv.line(),
          fmt::format(
              "time goes from {:.10g} s to {:.10g} s: it must increase; sort the rows, drop repeated ones, "
              "or write time with more digits",
              now_, time));
    // Both times of the step are rounded, and so are the ends of the span behind the expected one.
    constexpr double single_precision = 6e-8;
    const double rounding = written_resolution() + 2.0 * single_precision * std::abs(time);
    const double unresolved = rounding * (1.0 + 1.0 / static_cast<double>(std::max(1L, rows_ - 1)));
    if (std::abs(step - expected) <= 0.01 * expected + std::min(unresolved, 0.75 * expected)) return;
    throw Error(
        csv.file(), csv.line(),
        fmt::format(
            "a time step of {:.6g} s where {:.6g} s is expected: sampling must be uniform; fill the gap or "
            "resample the record, or write time with more digits",
            step, expected));
  }

  double to_si_ = 1.0;
  long rows_ = 0;
  double start_ = 0.0;
  double now_ = 0.0;
  int last_digit_ = 0;
};

void check(const std::string& name, const ChannelCorrection& correction) {
  const auto refuse = [&](const char* rule, double value) {
    throw Error(fmt::format("correction of channel '{}': {}, got {}", name, rule, value));
  };
  if (!std::isfinite(correction.sensitivity) || correction.sensitivity == 0.0)
    refuse("sensitivity must be finite and not zero", correction.sensitivity);
  if (std::abs(correction.sign) != 1.0) refuse("sign must be 1 or -1", correction.sign);
  if (!std::isfinite(correction.delay)) refuse("delay must be finite", correction.delay);
}

}  // namespace

struct RecordReader::State {
  CsvReader csv;
  Clock clock;
  std::vector<Channel> channels;
  std::vector<double> factors;
  std::vector<int> slots;       ///< of each column in the file: 0 time, k + 1 channel k, -1 none
  std::vector<double> numbers;  ///< of a row, by slot
  std::vector<ChannelWatch> watches;
  int time_digit = 0;

  explicit State(const std::string& file)
      : csv(file), clock(csv, file), slots(csv.header().size(), -1), numbers(1) {
    slots[static_cast<std::size_t>(csv.column("time"))] = 0;
  }

  void add_channel(const std::string& name, const ChannelCorrection& correction) {
    check(name, correction);
    const auto column = static_cast<std::size_t>(csv.column(name));
    if (slots[column] >= 0)
      throw Error(csv.file(), 1, fmt::format("column '{}' is asked for twice, or is the clock", name));
    const std::string& written = csv.header()[column].unit;
    const std::string& unit = correction.unit.empty() ? written : correction.unit;
    if (unit.empty())
      throw Error(
          csv.file(), 1,
          fmt::format("column '{}' has no unit: write '{} [N]', say, or give a unit in its correction", name,
                      name));
    const Unit parsed = Clock::unit_in_header(csv.file(), unit);
    channels.push_back({name, parsed.quantity, correction.delay});
    slots[column] = static_cast<int>(channels.size());
    watches.emplace_back();
    numbers.push_back(0.0);
    factors.push_back(parsed.to_si * correction.sensitivity * correction.sign);
  }
};

RecordReader::RecordReader(const std::string& file, const std::vector<std::string>& columns,
                           const std::map<std::string, ChannelCorrection>& corrections)
    : state_(std::make_unique<State>(file)) {
  for (const auto& [name, correction] : corrections)
    if (std::find(columns.begin(), columns.end(), name) == columns.end())
      throw Error(fmt::format("correction of channel '{}': it is not among the columns used ({})", name,
                              fmt::join(columns, ", ")));
  for (const auto& name : columns) {
    const auto correction = corrections.find(name);
    state_->add_channel(name, correction == corrections.end() ? ChannelCorrection{} : correction->second);
  }
}

RecordReader::~RecordReader() = default;
RecordReader::RecordReader(RecordReader&&) noexcept = default;

const std::vector<Channel>& RecordReader::channels() const {
  return state_->channels;
}
double RecordReader::sample_interval() const {
  return state_->clock.sample_interval();
}
double RecordReader::start() const {
  return state_->clock.start();
}
const std::vector<ChannelWatch>& RecordReader::watches() const {
  return state_->watches;
}

long RecordReader::read(Eigen::MatrixXd& block, long rows) {
  State& state = *state_;
  const long columns = static_cast<long>(state.channels.size());
  if (block.rows() < rows || block.cols() != columns) block.resize(rows, columns);
  long row = 0;
  while (row < rows && state.csv.next_numbers(state.slots, state.numbers, state.time_digit)) {
    state.clock.tick(state.csv, state.numbers[0], state.time_digit);
    for (long k = 0; k < columns; ++k)
      block(row, k) =
          state.factors[static_cast<std::size_t>(k)] * state.numbers[static_cast<std::size_t>(k + 1)];
    ++row;
  }
  for (long k = 0; k < columns; ++k) state.watches[static_cast<std::size_t>(k)].add(block.col(k).head(row));
  if (row < rows && state.clock.rows() < 2)
    throw Error(state.csv.file(), 0,
                fmt::format("has {} data row(s): a record needs at least 2", state.clock.rows()));
  return row;
}

std::vector<std::string> record_warnings(const std::string& file, const std::vector<Channel>& channels,
                                         const std::vector<ChannelWatch>& watches) {
  std::vector<std::string> warnings;
  const auto tell = [&](const Channel& channel, long samples, const char* which, double value) {
    if (samples == 0) return;
    warnings.push_back(fmt::format(
        "{}: {} samples of '{}' stand at its {} value, {:.6g} {}: clipped? measure again with a lower gain",
        file, samples, channel.name, which, value, si_unit(channel.quantity)));
  };
  for (std::size_t k = 0; k < watches.size(); ++k) {
    tell(channels[k], watches[k].at_upper_limit(), "largest", watches[k].upper());
    tell(channels[k], watches[k].at_lower_limit(), "smallest", watches[k].lower());
  }
  return warnings;
}

long count_rows(const std::string& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), std::fclose);
  if (!stream) throw Error(file, 0, "cannot be opened");
  std::vector<char> buffer(1 << 18);
  const std::string_view blanks = " \t\r\n";
  // Rows are the lines below the header up to the last one that is not blank.
  long line_ends = 0;  // so far
  long before_last_text =
      0;  // those before the last character that is not blank: the header's stands for the last row's
  while (const auto size = static_cast<long>(std::fread(buffer.data(), 1, buffer.size(), stream.get()))) {
    long text_end = size;
    while (text_end > 0 &&
           blanks.find(buffer[static_cast<std::size_t>(text_end - 1)]) != std::string_view::npos)
      --text_end;
    const long in_text = std::count(buffer.begin(), buffer.begin() + text_end, '\n');
    if (text_end > 0) before_last_text = line_ends + in_text;
    line_ends += in_text + std::count(buffer.begin() + text_end, buffer.begin() + size, '\n');
  }
  return before_last_text;
}

Record read_record(const std::string& file, const std::vector<std::string>& columns,
                   const std::map<std::string, ChannelCorrection>& corrections) {
  RecordReader reader(file, columns, corrections);
  Record record;
  record.channels = reader.channels();
  record.samples.resize(count_rows(file), static_cast<long>(columns.size()));
  Eigen::MatrixXd block;
  long rows = 0;
  while (const long got = reader.read(block, 4096)) {
    if (rows + got > record.samples.rows())
      record.samples.conservativeResize(2 * (rows + got), Eigen::NoChange);
    record.samples.middleRows(rows, got) = block.topRows(got);
    rows += got;
  }
  record.samples.conservativeResize(rows, Eigen::NoChange);
  record.start = reader.start();
  record.sample_interval = reader.sample_interval();
  return record;
}

void write_record(const Record& record, const std::string& file) {
  if (static_cast<long>(record.channels.size()) != record.samples.cols())
    throw Error(fmt::format("write_record: {} channels but {} columns of samples", record.channels.size(),
                            record.samples.cols()));
  if (!(record.sample_interval > 0.0))
    throw Error(
        fmt::format("write_record: sample interval must be positive, got {}", record.sample_interval));
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "time [s]");
  for (const Channel& channel : record.channels) {
    const std::string unit = si_unit(channel.quantity);
    if (unit.empty())
      throw Error(fmt::format("write_record: channel '{}' has no known quantity", channel.name));
    if (channel.delay != 0.0)
      throw Error(fmt::format("write_record: channel '{}' has a delay of {} s, which a file cannot tell",
                              channel.name, channel.delay));
    fmt::format_to(out, ",{} [{}]", channel.name, unit);
  }
  fmt::format_to(out, "\n");
  for (long i = 0; i < record.samples.rows(); ++i) {
    fmt::format_to(out, "{:.12g}", record.start + static_cast<double>(i) * record.sample_interval);
    for (long k = 0; k < record.samples.cols(); ++k) fmt::format_to(out, ",{:.9g}", record.samples(i, k));
    fmt::format_to(out, "\n");
  }
  write_atomically(file, std::string_view(text.data(), text.size()));
}

}  // namespace struna::ident
