#include "ident/repeats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/error.hpp"

namespace struna::ident {
namespace {

constexpr double segments_per_duration = 7.5;
constexpr double longest_segment = 100.0;  // [s], so that memory stays bounded however long the record

std::vector<std::string> columns_of(const std::string& input, const std::vector<std::string>& outputs) {
  if (outputs.empty()) throw Error("open_repeats: at least one output is needed");
  std::vector<std::string> columns{input};
  for (const auto& output : outputs) {
    if (std::find(columns.begin(), columns.end(), output) != columns.end())
      throw Error(fmt::format("open_repeats: column '{}' is named twice among input and outputs", output));
    columns.push_back(output);
  }
  return columns;
}

}  // namespace

Repeats open_repeats(const std::vector<std::string>& files, const std::string& input,
                     const std::vector<std::string>& outputs,
                     const std::map<std::string, ChannelCorrection>& corrections, bool count_samples) {
  if (files.empty()) throw Error("open_repeats: at least one record is needed");
  const std::vector<std::string> columns = columns_of(input, outputs);
  Repeats repeats;
  for (const std::string& file : files) {
    RecordReader head(file, columns, corrections);
    Eigen::MatrixXd first_rows;
    head.read(first_rows, 1000);
    const auto& there = head.channels();
    if (repeats.channels.empty()) repeats.channels = there;
    for (std::size_t k = 0; k < there.size(); ++k)
      if (there[k].quantity != repeats.channels[k].quantity)
        throw Error(file, 1,
                    fmt::format("column '{}' is in {} here and in {} in {}: repeats must measure the same",
                                columns[k], si_unit(there[k].quantity), si_unit(repeats.channels[k].quantity),
                                files[0]));
    const auto watches = std::make_shared<std::vector<ChannelWatch>>();
    const auto open = [file, columns, corrections, watches] {
      auto reader = std::make_shared<RecordReader>(file, columns, corrections);
      return Rows{[reader, watches](Eigen::MatrixXd& block, long rows) {
                    const long got = reader->read(block, rows);
                    if (got < rows) *watches = reader->watches();
                    return got;
                  },
                  [reader] { return reader->sample_interval(); }};
    };
    repeats.records.push_back(
        {file, head.sample_interval(), count_samples ? count_rows(file) : 0, open, watches});
  }
  return repeats;
}

std::vector<std::string> record_warnings(const Repeats& repeats, bool impact) {
  // Pulses of half a sine in a twentieth of the record: 2/3 of that.
  constexpr double hit_share = 0.033;
  constexpr double hit_one_sidedness = 0.7;
  std::vector<std::string> warnings;
  for (const Repeat& repeat : repeats.records) {
    if (!repeat.watches || repeat.watches->empty()) continue;
    for (auto& warning : record_warnings(repeat.name, repeats.channels, *repeat.watches))
      warnings.push_back(std::move(warning));
    const ChannelWatch& input = repeat.watches->front();
    if (!impact && input.active_share() > 0.0 && input.active_share() < hit_share &&
        input.one_sidedness() > hit_one_sidedness)
      warnings.push_back(
          fmt::format("{}: '{}' acts in {:.2g} % of the record, to one side, as a hammer does: use --impact, "
                      "with one hit "
                      "per record",
                      repeat.name, repeats.channels.front().name, 150.0 * input.active_share()));
  }
  return warnings;
}

Repeats open_repeats(const Record& record, const std::string& input,
                     const std::vector<std::string>& outputs) {
  if (!record.samples.allFinite()) throw Error("open_repeats: the record holds values that are not finite");
  if (!(record.sample_interval > 0.0))
    throw Error(
        fmt::format("open_repeats: sample interval must be positive, got {}", record.sample_interval));
  Repeats repeats;
  std::vector<long> column;
  for (const std::string& name : columns_of(input, outputs)) {
    const auto found = std::find_if(record.channels.begin(), record.channels.end(),
                                    [&name](const Channel& channel) { return channel.name == name; });
    if (found == record.channels.end())
      throw Error(fmt::format("open_repeats: the record has no channel '{}'", name));
    repeats.channels.push_back(*found);
    column.push_back(found - record.channels.begin());
  }
  const auto open = [&record, column] {
    const auto next = std::make_shared<long>(0);
    return Rows{[&record, column, next](Eigen::MatrixXd& block, long rows) {
                  const long got = std::min(rows, record.samples.rows() - *next);
                  block.resize(rows, static_cast<long>(column.size()));
                  for (std::size_t k = 0; k < column.size(); ++k)
                    block.col(static_cast<long>(k)).head(got) =
                        record.samples.col(column[k]).segment(*next, got);
                  *next += got;
                  return got;
                },
                [&record] { return record.sample_interval; }};
  };
  repeats.records = {{"record", record.sample_interval, record.samples.rows(), open, {}}};
  return repeats;
}

Repeats open_repeats(const std::vector<Record>& records, const std::string& input,
                     const std::vector<std::string>& outputs) {
  if (records.empty()) throw Error("open_repeats: at least one record, got none");
  Repeats all;
  for (const Record& record : records) {
    Repeats one = open_repeats(record, input, outputs);
    if (all.records.empty()) all.channels = std::move(one.channels);
    all.records.push_back(std::move(one.records.front()));
  }
  return all;
}

void check_sampled_alike(const std::vector<Repeat>& records) {
  for (const Repeat& record : records)
    if (std::abs(record.sample_interval / records[0].sample_interval - 1.0) > 1e-3)
      throw Error(
          record.name, 0,
          fmt::format("has a sample interval of {:.6g} s, {} has {:.6g} s: repeats must be sampled alike",
                      record.sample_interval, records[0].name, records[0].sample_interval));
}

double automatic_segment(const std::vector<Repeat>& records) {
  double together = 0.0;
  double shortest = longest_segment;
  for (const Repeat& record : records) {
    together += record.duration();
    shortest = std::min(shortest, record.duration());
  }
  return std::min(together / segments_per_duration, shortest);
}

Eigen::MatrixXd read_whole(const Repeat& record, Rows& rows, long channels) {
  Eigen::MatrixXd samples(record.samples, channels);
  Eigen::MatrixXd block;
  long filled = 0;
  while (const long got = rows.read(block, 4096)) {
    if (filled + got > samples.rows()) throw Error(record.name, 0, "has changed while it was read");
    samples.middleRows(filled, got) = block.topRows(got);
    filled += got;
  }
  if (filled < samples.rows()) samples.conservativeResize(filled, channels);
  return samples;
}

}  // namespace struna::ident
