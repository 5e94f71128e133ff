// Records to transfer functions: time of reading against fast-cpp-csv-parser alone, and of the whole way, one
// thread.
//   records_bench generate FILE ROWS CHANNELS    writes a records CSV: time and CHANNELS columns of filtered
//   noise records_bench read FILE                      both readers on the 4-column FILE records_bench
//   transfer FILE HZ OUT.csv       records to three transfer functions at that resolution
// Rows: method, knob, value, error, time [s]. The error of `read` is the largest deviation between the two
// readers; records_bench.py runs all of it beside numpy and scipy.
#define CSV_IO_NO_THREAD
#if defined(__GNUC__) && !defined(__clang__)
// The library's own error type cuts file names at 255 characters with strncpy and ends them by hand.
#pragma GCC diagnostic ignored "-Wstringop-truncation"
#endif
#include <fmt/format.h>
#include <libfccp/csv.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>

#include "ident/record.hpp"
#include "ident/spectra.hpp"
#include "ident/transfer_function.hpp"
#include "ident/transfer_function_file.hpp"

namespace {

using namespace struna::ident;

const std::vector<std::string> outputs{"force_x", "force_y", "force_z"};

/// Processor time, median of five runs [s]: one thread, so it is what a clock would show on an idle machine.
template <class Work>
double seconds(Work work) {
  std::vector<double> times;
  for (int run = 0; run < 5; ++run) {
    const std::clock_t start = std::clock();
    work();
    times.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::nth_element(times.begin(), times.begin() + 2, times.end());
  return times[2];
}

void generate(const std::string& file, long rows, long channels) {
  Record record;
  record.sample_interval = 1.0 / 25600.0;
  record.channels = {{"displacement", Quantity::displacement, 0.0}};
  for (long k = 1; k < channels; ++k)
    record.channels.push_back({outputs[static_cast<std::size_t>(k - 1)], Quantity::force, 0.0});
  record.samples.resize(rows, channels);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  double state = 0.0;
  for (long i = 0; i < rows; ++i) {
    const double x = 1e-4 * normal(random);
    state = 0.9 * state + 1e4 * x;
    record.samples(i, 0) = x;
    for (long k = 1; k < channels; ++k)
      record.samples(i, k) = static_cast<double>(k) * state + 0.1 * normal(random);
  }
  write_record(record, file);
}

void read_both(const std::string& file) {
  double theirs = 0.0;
  const double alone = seconds([&] {
    io::CSVReader<4> reader(file);
    reader.next_line();  // the header
    double time, a, b, c;
    theirs = 0.0;
    while (reader.read_row(time, a, b, c)) theirs += time + a + b + c;
  });
  double ours = 0.0;
  const double struna = seconds([&] {
    RecordReader reader(file, {"displacement", "force_x", "force_y"});
    Eigen::MatrixXd block;
    ours = 0.0;
    long rows = 0;
    while (const long got = reader.read(block, 4096)) {
      ours += block.topRows(got).sum();
      rows += got;
    }
    // The clock's column, which RecordReader checks but does not hand out.
    ours += static_cast<double>(rows) *
            (reader.start() + 0.5 * static_cast<double>(rows - 1) * reader.sample_interval());
  });
  const double error = std::abs(ours / theirs - 1.0);
  fmt::print("fast-cpp-csv-parser,columns,4,0,{:.4f}\n", alone);
  fmt::print("struna RecordReader,columns,4,{:.1e},{:.4f}\n", error, struna);
}

void transfer(const std::string& file, double resolution_hz, const std::string& to) {
  WelchOptions options;
  options.resolution_hz = resolution_hz;
  options.overlap = 0.5;
  options.window = Window::hann;
  TransferFunction tf;
  const double time = seconds([&] {
    tf = estimate_transfer_function(welch_spectra({file}, "displacement", outputs, options), Estimator::h1);
  });
  write_transfer_function(tf, to);
  fmt::print("struna read + 3 H1 + coherence + sigma,resolution [Hz],{},0,{:.4f}\n", resolution_hz, time);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() == 4 && words[0] == "generate")
      generate(words[1], std::atol(words[2].c_str()), std::atol(words[3].c_str()));
    else if (words.size() == 2 && words[0] == "read")
      read_both(words[1]);
    else if (words.size() == 4 && words[0] == "transfer")
      transfer(words[1], std::atof(words[2].c_str()), words[3]);
    else
      throw std::runtime_error(
          "usage: records_bench generate FILE ROWS CHANNELS | read FILE | transfer FILE HZ OUT.csv");
  } catch (const std::exception& error) {
    fmt::print(stderr, "records_bench: {}\n", error.what());
    return 1;
  }
  return 0;
}
