#include "apps/bootstrap.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "ident/references.hpp"
#include "ident/wild_records.hpp"

namespace struna::apps {
namespace {

std::vector<ident::Record> read_records(const Study& study, const StudyReference& reference) {
  std::vector<std::string> columns = study.outputs;
  columns.insert(columns.begin(), reference.input);
  std::vector<ident::Record> records;
  double values = 0.0;
  for (const std::string& file : reference.records) {
    records.push_back(ident::read_record(file, columns, corrections_of(study, reference)));
    values += static_cast<double>(records.back().samples.size());
    if (values > static_cast<double>(ident::most_values))
      throw Error(file, 0,
                  fmt::format("bootstrap: the records hold more than {} values, which do not fit into memory "
                              "several times: take fewer of them",
                              ident::most_values));
  }
  return records;
}

/// The estimator that the study's own records took, so that no replicate takes another.
ident::EstimateOptions options_of(const Study& study, const ident::TransferEstimate& estimate) {
  ident::EstimateOptions options{study.transfer.method, study.transfer.estimator, study.transfer.welch, {}};
  options.method = estimate.method;
  if (estimate.method == ident::EstimateMethod::welch && !options.welch.impact)
    options.welch.window = estimate.window;
  return options;
}

}  // namespace

std::map<std::string, ident::ChannelCorrection> corrections_of(const Study& study,
                                                               const StudyReference& reference) {
  std::map<std::string, ident::ChannelCorrection> own = study.corrections;
  std::erase_if(own, [&](const auto& entry) {
    return entry.first != reference.input &&
           std::count(study.outputs.begin(), study.outputs.end(), entry.first) == 0;
  });
  return own;
}

ident::BootstrapScatter bootstrap(const Study& study, const std::vector<ident::TransferEstimate>& estimates,
                                  const ident::ModeSet& nominal, long replicates) {
  std::vector<ident::WildRecords> sources;
  long blocks = 0;
  for (std::size_t j = 0; j < study.references.size(); ++j) {
    const StudyReference& reference = study.references[j];
    sources.emplace_back(read_records(study, reference), reference.input, study.outputs, estimates[j],
                         study.transfer.welch.impact);
    blocks += sources.back().blocks();
  }
  std::mt19937_64 random(1);
  std::vector<ident::ModeSet> sets;
  for (long n = 0; n < replicates; ++n) {
    std::vector<ident::NamedReference> functions;
    for (std::size_t j = 0; j < sources.size(); ++j) {
      const StudyReference& reference = study.references[j];
      ident::TransferFunction function =
          ident::estimate_transfer(sources[j].draw(random), reference.input, study.outputs,
                                   options_of(study, estimates[j]))
              .function;
      functions.push_back(
          {reference.name, reference.records.front(), in_band_and_form(std::move(function), study.transfer)});
    }
    sets.push_back(ident::identify_modes(ident::combine_references(functions), study.modes));
  }
  return ident::bootstrap_scatter(nominal, sets, blocks);
}

std::optional<ident::Doubt> scatter_doubt(const ident::BootstrapScatter& scatter) {
  const auto doubtful = std::count_if(scatter.modes.begin(), scatter.modes.end(),
                                      [](const ident::ModeScatter& mode) { return mode.doubtful; });
  if (doubtful == 0) return std::nullopt;
  ident::Doubt doubt;
  doubt.kind = ident::DoubtKind::scatter_differs;
  doubt.count = static_cast<int>(doubtful);
  doubt.of = static_cast<int>(scatter.modes.size());
  doubt.value = scatter.frequency_ratio;
  doubt.other = scatter.loss_factor_ratio;
  return doubt;
}

std::string bootstrap_line(const ident::BootstrapScatter& scatter) {
  return fmt::format(
      "bootstrap, {} replicates: scatter over stated error {:.2f} (frequencies), {:.2f} (loss factors), of "
      "one "
      "mode +- {:.2f}",
      scatter.replicates, scatter.frequency_ratio, scatter.loss_factor_ratio, scatter.ratio_sigma);
}

}  // namespace struna::apps
