#include "ident/drive_signal.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

using Complex = std::complex<double>;

constexpr double least_certain = 10.0;  // |G_x| over its sigma; at 5 the ratio is 2 % off, at 10 0.3 %

/// Ratio of the rms of output k and of the input over all records.
double level_ratio(const std::vector<RecordSpectrum>& records, long output) {
  double x = 0.0, y = 0.0;
  for (const RecordSpectrum& record : records) {
    x += record.lines.col(1).squaredNorm();
    y += record.lines.col(output).squaredNorm();
  }
  return x > 0.0 ? std::sqrt(y / x) : 0.0;
}

/// Drive signal, input, outputs y_k, then y_k + s_k x and y_k + i s_k x of each: the powers of their noise
/// tell the cross-spectrum of the noise of x and y_k. All five come out of one window with one denominator,
/// so that nothing but rounding is lost in the differences.
std::vector<RecordSpectrum> with_sums(const std::vector<RecordSpectrum>& records,
                                      const std::vector<double>& level) {
  std::vector<RecordSpectrum> all;
  for (const RecordSpectrum& record : records) {
    const long channels = record.lines.cols(), outputs = channels - 2;
    RecordSpectrum wide{record.line_spacing_hz,
                        Eigen::MatrixXcd(record.lines.rows(), channels + 2 * outputs)};
    wide.lines.leftCols(channels) = record.lines;
    for (long k = 0; k < outputs; ++k) {
      const double s = level[static_cast<std::size_t>(k)];
      wide.lines.col(channels + 2 * k) = record.lines.col(2 + k) + s * record.lines.col(1);
      wide.lines.col(channels + 2 * k + 1) = record.lines.col(2 + k) + Complex(0.0, s) * record.lines.col(1);
    }
    all.push_back(std::move(wide));
  }
  return all;
}

/// Power of the noise of y_k - H x from the noise powers of x, y, y + s x and y + i s x.
double remaining_power(const Eigen::Ref<const Eigen::RowVectorXd>& noise, long outputs, long k, double level,
                       Complex h) {
  const double xx = noise[0], yy = noise[1 + k];
  const double real = (noise[1 + outputs + 2 * k] - yy - level * level * xx) / (2.0 * level);
  const double imag = (noise[2 + outputs + 2 * k] - yy - level * level * xx) / (2.0 * level);
  const Complex xy(real, imag);  // mean conj(x) y: |y + i s x|^2 has 2 s Im(conj(x) y)
  const double rest = yy - 2.0 * (std::conj(h) * xy).real() + std::norm(h) * xx;
  return std::max(rest, 1e-12 * (yy + std::norm(h) * xx));
}

}  // namespace

LocalModel local_model_by_drive(const std::vector<RecordSpectrum>& records, double highest_hz,
                                const LocalModelOptions& options) {
  if (records.empty() || records.front().lines.cols() < 3)
    throw Error("local_model_by_drive: a drive signal, an input and at least one output are needed");
  const long outputs = records.front().lines.cols() - 2;
  std::vector<double> level;
  for (long k = 0; k < outputs; ++k) level.push_back(level_ratio(records, 2 + k));
  const LocalModel about_drive = local_model(records, highest_hz, options);
  const LocalModel wide = local_model(with_sums(records, level), highest_hz, options);
  if (wide.frequency_hz.size() != about_drive.frequency_hz.size())
    throw Error("local_model_by_drive: the two passes differ in lines");

  // What noise of unit power does to a function over the drive at a line. Errors of the common denominator
  // come on top in sigma; they are alike in both functions and leave the ratio: the smaller value has less of
  // them.
  const auto leverage = [&](long line, long k) {
    const auto of = [&](long output) {
      return std::pow(about_drive.sigma(line, output), 2.0) / about_drive.noise_power(line, output);
    };
    return std::min(of(0), of(1 + k));
  };
  LocalModel model;
  std::vector<long> kept;
  for (long i = 0; i < about_drive.frequency_hz.size(); ++i)
    if (std::abs(about_drive.value(i, 0)) > least_certain * about_drive.sigma(i, 0)) kept.push_back(i);
  const long lines = static_cast<long>(kept.size());
  model.frequency_hz = about_drive.frequency_hz(kept);
  model.input_power.resize(lines);
  model.value.resize(lines, outputs);
  for (Eigen::MatrixXd* m : {&model.sigma, &model.coherence, &model.noise_power}) m->resize(lines, outputs);
  for (long i = 0; i < lines; ++i) {
    const long line = kept[static_cast<std::size_t>(i)];
    const Complex x = about_drive.value(line, 0);
    model.input_power[i] = std::norm(x) * about_drive.input_power[line] + about_drive.noise_power(line, 0);
    for (long k = 0; k < outputs; ++k) {
      const Complex h = about_drive.value(line, 1 + k) / x;
      const double power =
          remaining_power(wide.noise_power.row(line), outputs, k, level[static_cast<std::size_t>(k)], h);
      model.value(i, k) = h;
      model.sigma(i, k) = std::sqrt(leverage(line, k) * power) / std::abs(x);
      model.noise_power(i, k) = power;
      const double signal = std::norm(h) * model.input_power[i];
      model.coherence(i, k) = signal / (signal + model.noise_power(i, k));
    }
  }
  return model;
}

}  // namespace struna::ident
